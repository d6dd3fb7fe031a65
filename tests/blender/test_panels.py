# SPDX-License-Identifier: GPL-3.0-or-later
"""Panels draw in every situation, on a stub layout that raises errors where a real one prints to the console."""

import types

import bpy
import pytest
from bl_ext.user_default.sinew import ui
from bl_ext.user_default.sinew.live import session
from bl_ext.user_default.sinew.scene import selection, tissue_empty
from bl_ext.user_default.sinew.ui import skin_panel, tissue_list
from conftest import add_muscle, bind, select

PANELS = [cls for cls in ui._CLASSES if issubclass(cls, bpy.types.Panel)]
LONGEST_LABEL = 42  # characters that the sidebar shows at its default width
ICONS = set(bpy.types.UILayout.bl_rna.functions["prop"].parameters["icon"].enum_items.keys())


class Layout:
    """Records the drawing; raises if a property, operator, icon or argument does not exist."""

    def __init__(self, drawn):
        object.__setattr__(self, "drawn", drawn)

    def _call(self, function, *args, **settings):
        known = bpy.types.UILayout.bl_rna.functions[function].parameters
        assert set(settings) <= set(known.keys()), f"{function}: {settings}"
        assert settings.get("icon", "NONE") in ICONS
        assert len(settings.get("text", "")) <= LONGEST_LABEL
        self.drawn.append((function, *(arg for arg in args if isinstance(arg, str)), settings.get("text", "")))

    def row(self, **settings):
        self._call("row", **settings)
        return Layout(self.drawn)

    def column(self, **settings):
        self._call("column", **settings)
        return Layout(self.drawn)

    def menu(self, name, **settings):
        assert hasattr(bpy.types, name), name
        self._call("menu", name, **settings)

    def split(self, **settings):
        self._call("split", **settings)
        return Layout(self.drawn)

    def label(self, **settings):
        self._call("label", **settings)

    def prop(self, data, name, **settings):
        assert name in data.bl_rna.properties, name
        getattr(data, name)
        self._call("prop", name, **settings)

    def prop_enum(self, data, name, value, **settings):
        self.prop(data, name)
        self._call("prop_enum", value, **settings)

    def prop_decorator(self, data, name, **settings):
        self.prop(data, name)
        self._call("prop_decorator", name, **settings)

    def separator(self, **settings):
        self._call("separator", **settings)

    def prop_search(self, data, name, where, collection, **settings):
        assert name in data.bl_rna.properties and collection in where.bl_rna.properties
        self._call("prop_search", name, **settings)

    def operator(self, name, **settings):
        module, operator = name.split(".")
        assert hasattr(bpy.types, f"{module.upper()}_OT_{operator}"), name
        self._call("operator", name, **settings)
        return types.SimpleNamespace()

    def operator_menu_enum(self, name, _property, **settings):
        self.operator(name)
        self._call("operator_menu_enum", name, **settings)

    def template_list(self, kind, _id, data, name, active_data, active_name, **settings):
        assert hasattr(bpy.types, kind)
        getattr(active_data, active_name)
        rows = filter_of()
        list_ = types.SimpleNamespace(layout=self)
        for shown, item in zip(rows, getattr(data, name)):
            if shown:
                tissue_list.SINEW_UL_tissues.draw_item(
                    list_, bpy.context, self, data, item, 0, active_data, active_name, 0, 0
                )
        self._call("template_list", name, **settings)


def filter_of(name="", invert=False, kinds=()):
    """The names in the list, by the flags that Blender reads."""
    list_ = types.SimpleNamespace(
        bitflag_filter_item=1 << 30,
        filter_name=name,
        use_filter_invert=invert,
        kinds=set(kinds),
        has_shown_search=False,
    )
    list_._matches = types.MethodType(tissue_list.SINEW_UL_tissues._matches, list_)
    flags, _order = tissue_list.SINEW_UL_tissues.filter_items(list_, bpy.context, bpy.data, "objects")
    return [bool(flag) != invert for flag in flags]


def draw_all():
    drawn = []
    for panel in PANELS:
        if not hasattr(panel, "poll") or panel.poll(bpy.context):
            drawn.append(("panel", panel.bl_label))
            own = types.SimpleNamespace(layout=Layout(drawn))
            for name in ("_draw_shaded",):
                if hasattr(panel, name):
                    setattr(own, name, types.MethodType(getattr(panel, name), own))
            if hasattr(panel, "draw_header"):
                panel.draw_header(own, bpy.context)
            panel.draw(own, bpy.context)
    return drawn


def texts(drawn):
    # a long text is several labels, so the word "label" is left out
    return " ".join(part for entry in drawn for part in entry[entry[0] == "label" :] if isinstance(part, str))


def test_nothing_selected():
    assert "import a character" in texts(draw_all())
    bpy.ops.object.armature_add()
    bpy.ops.object.light_add()
    assert "Select an armature, its mesh or one of its" in texts(draw_all())


def test_every_kind_of_active_object(arm):
    skin, rig = arm
    muscle = add_muscle(rig)
    bind(skin)
    bpy.ops.object.camera_add()
    camera = bpy.context.object
    for active in (skin, rig, muscle, camera):
        select(active)
        drawn = draw_all()
        is_of_character = active != camera
        assert (("panel", "1 Muscles") in drawn) == is_of_character and (("panel", "3 Bake") in drawn) == is_of_character
    select(rig)
    bpy.ops.object.mode_set(mode="POSE")
    draw_all()
    bpy.ops.object.mode_set(mode="EDIT")
    draw_all()


def test_every_kind_of_tissue_shows_its_settings(arm):
    _skin, rig = arm
    muscle = add_muscle(rig)
    select(muscle)
    assert "tension" in texts(draw_all())
    for kind in ("BONE", "STUFFING", "SPHERE"):
        select(rig)
        bpy.ops.sinew.add_tissue(kind=kind, origin_bone="lower")
        select(bpy.data.objects[f"{kind.title()} lower"])
        drawn = texts(draw_all())
        assert "semi_axes" in drawn and "offset" in drawn and "tension" not in drawn
    muscle.parent = None
    select(muscle)
    assert "Parent it to a bone" in texts(draw_all())


def test_vanished_bones_are_marked_and_named(arm):
    _skin, rig = arm
    muscle = add_muscle(rig, name="Biceps")
    muscle.sinew.tissue.insertion_bone = "gone"
    bpy.context.view_layer.update()
    select(rig)
    drawn = draw_all()
    assert "insertion bone 'gone' is not in" in texts(drawn).replace("  ", " ")
    select(muscle)
    assert "Selected Tissue" in texts(draw_all())


def test_the_list_shows_and_finds_the_tissues_of_the_rig(arm):
    from conftest import make_arm

    _skin, rig = arm
    add_muscle(rig, name="Biceps")
    add_muscle(rig, name="Triceps")
    bpy.ops.sinew.add_tissue(kind="SPHERE", origin_bone="lower", name="Elbow")
    _other_skin, other = make_arm("Other")
    add_muscle(other, name="Foreign")
    select(rig)

    def shown(**settings):
        return [found.name for found, is_shown in zip(bpy.data.objects, filter_of(**settings)) if is_shown]

    assert shown() == ["Biceps", "Elbow", "Triceps"]
    assert shown(name="ceps") == ["Biceps", "Triceps"] and shown(name="BI") == ["Biceps"]
    assert shown(name="ceps", invert=True) == ["Elbow"]
    assert shown(kinds=("SPHERE",)) == ["Elbow"]
    assert shown(name="ceps", kinds=("SPHERE",)) == []


def test_a_click_selects_the_tissue(arm):
    _skin, rig = arm
    first, second = add_muscle(rig, name="A"), add_muscle(rig, name="B")
    select(rig)
    assert rig.sinew.rig.active_tissue == -1
    rig.sinew.rig.active_tissue = bpy.data.objects.find("B")
    assert bpy.context.object == second and bpy.context.selected_objects == [second]
    assert rig.sinew.rig.active_tissue == bpy.data.objects.find("B")
    select(rig)
    bpy.ops.object.mode_set(mode="POSE")
    rig.sinew.rig.active_tissue = bpy.data.objects.find("A")
    assert bpy.context.object == first and rig.mode == "OBJECT"
    rig.sinew.rig.active_tissue = bpy.data.objects.find("Arm")
    assert bpy.context.object == first
    second.users_collection[0].objects.unlink(second)
    selection.select(second)
    assert bpy.context.object == first


def test_layers_and_shaded_muscles_draw(arm):
    skin, rig = arm
    add_muscle(rig)
    bind(skin)
    rig.sinew.rig.show_shaded = True
    select(rig)
    drawn = texts(draw_all())
    assert "show_shaded" in drawn and "hide_render" in drawn and "show_attachments" in drawn


def test_the_skins_settings_and_those_of_the_active_bone_are_shown(arm):
    skin, rig = arm
    add_muscle(rig)
    rig.data.bones.active = None
    select(skin)
    assert ("panel", "Elasticity") not in draw_all()
    bind(skin)
    drawn = draw_all()
    assert ("panel", "Elasticity") in drawn and ("panel", "Bone Settings") not in drawn
    assert "fat_sliding" in texts(drawn) and "keep_volume" not in texts(drawn)
    rig.data.bones.active = rig.data.bones["lower"]
    for active in (skin, rig):
        select(active)
        drawn = draw_all()
        assert ("label", "lower") in drawn and "keep_volume" in texts(drawn)
    bpy.ops.object.mode_set(mode="EDIT")
    draw_all()


def test_problems_of_the_last_frame_are_shown(arm):
    skin, rig = arm
    muscle = add_muscle(rig, name="Biceps")
    bind(skin)
    assert "Biceps" not in texts(draw_all()) and "Correction limited" not in texts(draw_all())
    shape = tissue_empty.read(muscle, rig)
    rig.pose.bones["lower"].location.y = shape.origin.x - shape.insertion.x  # both bones are along X
    bpy.context.view_layer.update()
    state = session.cached_skin(skin)
    assert state.report.clamped == ["Biceps"]
    assert "At minimum length: Biceps" in texts(draw_all())
    skin_panel._draw_report(Layout(drawn := []), types.SimpleNamespace(report=MANY))
    words = texts(drawn).replace("label", "").split()
    assert "0, 1, 2, 3, 4, 5 and 2 more" in " ".join(words) and "limited on 9 vertices" in " ".join(words)


MANY = types.SimpleNamespace(clamped=list("01234567"), damped=9)


def test_edit_rest_pose_shows_its_state(arm):
    _skin, rig = arm
    add_muscle(rig)
    select(rig)
    assert "Editing the Rest Pose" not in texts(draw_all())
    bpy.ops.sinew.edit_rest_pose()
    assert "Editing the Rest Pose" in texts(draw_all())


OPERATORS = sorted(name for name in dir(bpy.types) if name.startswith("SINEW_OT_"))


def is_explained(text: str) -> bool:
    """Whether a tooltip says something: at least three words, without the period that Blender adds."""
    return len(text.split()) >= 3 and not text.endswith(".")


def rna_of(name: str):
    return getattr(bpy.ops.sinew, name.removeprefix("SINEW_OT_")).get_rna_type()


@pytest.mark.parametrize("name", OPERATORS)
def test_every_operator_explains_itself(name):
    operator = rna_of(name)
    assert operator.name and is_explained(operator.description), operator.description
    writes_files_alone = (
        *("SINEW_OT_save_musculature", "SINEW_OT_export"),
        *("SINEW_OT_save_preset", "SINEW_OT_rename_preset", "SINEW_OT_delete_preset", "SINEW_OT_make_assets"),
    )
    assert name in writes_files_alone or "UNDO" in getattr(bpy.types, name).bl_options


@pytest.mark.parametrize("name", OPERATORS)
def test_every_property_of_an_operator_has_a_tooltip(name):
    shown = [found for found in rna_of(name).properties if not found.is_hidden and found.identifier != "rna_type"]
    for found in shown:
        assert found.name and is_explained(found.description), f"{found.identifier}: {found.description!r}"
        for item in found.enum_items_static if found.type == "ENUM" else ():
            assert item.name and item.description and not item.description.endswith("."), f"{found.identifier}, {item.name}"


def test_no_two_operators_share_a_label():
    assert len(OPERATORS) > 25
    labels = [rna_of(name).name for name in OPERATORS]
    assert sorted(set(labels)) == sorted(labels)
    assert max(map(len, labels)) <= LONGEST_LABEL


def test_drawing_leaves_no_trace_on_objects_without_sinew(arm):
    skin, rig = arm
    camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    empty = bpy.data.objects.new("Empty", None)
    for found in (camera, empty):
        bpy.context.scene.collection.objects.link(found)
    for found in (camera, empty, skin, rig):
        select(found)
        assert draw_all()
    assert not any(found.is_property_set("sinew") for found in bpy.data.objects)
    assert not any(bone.is_property_set("sinew") for bone in rig.pose.bones)
