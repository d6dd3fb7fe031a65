# SPDX-License-Identifier: GPL-3.0-or-later
"""What the words of a bone name say: the side, the part of the limb or trunk, and whether it is a control bone.

The table holds words of ten languages and the abbreviations of common rigs. A new language needs new words and no code.
Words are compared as whole words, without case and accents; "UpperArm", "upper_arm" and "upperarm" are the same word.
"""

import functools
import re
import unicodedata
from collections import Counter
from collections.abc import Collection
from dataclasses import dataclass

# Sided words that may be two parts ("shoulder": the collar bone or the upper arm) have an entry of their own.
# `names.py` decides by the order of the bones.
WORDS = {
    "left": """left l lft lf lt links linke linker linkes gauche izquierda izquierdo izq esquerda esquerdo esq
        sinistra sinistro sx левый левая левое лев lev levyi levaya hidari 左 ひだり 왼쪽 왼 좌""",
    "right": """right r rgt rt rechts rechte rechter rechtes droite droit derecha derecho der direita direito
        dir destra destro dx правый правая правое прав prav pravyi pravaya migi 右 みぎ 오른쪽 오른 우""",
    "pelvis": """pelvis pelves hips pelvic lowertorso lowerbody becken bassin caderas pelve quadris bacia bacino
        fianchi pelvi таз taz kosi koshi kahanshin 下半身 腰 こし 骨盤 骨盆 盆骨 臀部 髋 髖 臀 골반 엉덩이""",
    "hip": "hip hüfte huefte hanche hanches cadera quadril anca anche бедра",
    "trunk": """spine abdomen torso chest thorax ribcage stomach belly lumbar trunk waist upperchest uppertorso
        upperbody body wirbelsäule wirbelsaeule rückgrat rueckgrat rücken ruecken brust brustkorb bauch rumpf
        colonne colonnevertébrale dos échine poitrine torse buste ventre columna espina espalda pecho tórax
        vientre barriga coluna espinha costas peito spina colonna schiena dorso petto torace busto addome
        позвоночник спина грудь живот pozvonochnik grud zhivot mune sebone jouhanshin johanshin 上半身 背骨 脊椎 せぼね 胸
        むね 腹 脊柱 脊骨 腰椎 胸部 腹部 척추 등뼈 가슴 흉부 복부 배""",
    "back": "back",
    "neck": "neck cervical hals nacken cou nuque cuello pescoço collo шея sheya sheia kubi 首 くび 脖子 颈 頸 颈部 목",
    "head": "head skull cranium kopf tête cabeza cabeça testa голова golova atama 頭 あたま 头 头部 머리",
    "jaw": """jaw mandible lowerjaw chin kinn menton mento kiefer unterkiefer mâchoire mandíbula quijada mascella
        mandibola челюсть chelyust 顎 あご 下顎 下巴 下颌 턱""",
    "tail": "tail schwanz schweif queue cola cauda rabo coda хвост hvost khvost shippo 尻尾 しっぽ 尾 尾巴 꼬리",
    "girdle": """clavicle clav collar collarbone scapula shoulderblade schlüsselbein schluesselbein
        schulterblatt clavicule omoplate clavícula clavicola ключица лопатка klyuchica kluchica lopatka sakotsu
        鎖骨 さこつ 锁骨 쇄골 빗장뼈""",
    "shoulder": "shoulder schulter épaule hombro ombro spalla плечо plecho kata 肩 かた 肩膀 肩部 어깨",
    "upper_arm": "upperarm uparm armupper bicep humerus shldr oberarm upparm 上腕 上臂 大臂 위팔 상완",
    "arm": "arm bras brazo braço braccio рука ruka ude 腕 うで 胳膊 手臂 팔",
    "elbow": "elbow ellbogen ellenbogen coude codo cotovelo gomito локоть lokot hiji ひじ 肘 手肘 팔꿈치",
    "forearm": """forearm lowerarm loarm lowarm armlower radius ulna unterarm avantbras antebrazo antebraço
        avambraccio предплечье predpleche zenwan 前腕 前臂 小臂 下臂 아래팔 전완 팔뚝""",
    "hand": "hand palm main mano mão кисть ладонь kist ladon 手 手掌 손",
    "wrist": "wrist carpus handgelenk poignet muñeca pulso polso запястье tekubi 手首 てくび 手腕 손목",
    "thumb": "thumb daumen pouce pulgar polegar pollice oyayubi 親指 拇指 大拇指 엄지",
    "index": "index pointer zeigefinger índice indicador указательный hitosashi hitoyubi 人指 人差指 人差し指 食指 검지",
    "middle": "middle mittelfinger majeur средний nakayubi 中指 중지",
    "ring": "ring ringfinger annulaire anular anelar anulare безымянный kusuri 薬指 无名指 無名指 약지",
    "little": "little pinky pinkie kleinfinger auriculaire meñique mindinho mignolo мизинец koyubi 小指 小拇指 새끼",
    "finger": "finger fingers digit doigt dito палец yubi 指 ゆび 手指 손가락",
    "thigh": """thigh upleg upperleg femur oberschenkel schenkel cuisse muslo coxa coscia бедро bedro momo 太もも
        もも 腿 大腿 허벅지 넓적다리""",
    "leg": "leg bein jambe pierna perna gamba нога noga ashi asi 다리",
    "leg_or_foot": "足 脚",
    "knee": "knee knie genou rodilla joelho ginocchio колено koleno hiza ひざ 膝 膝盖 무릎",
    "shin": """shin calf lowerleg lowleg loleg crus gaskin stifle tibia unterschenkel schienbein wade mollet
        espinilla pantorrilla canela panturrilha stinco polpaccio голень golen すね 脛 sune 小腿 胫 정강이 종아리""",
    "ankle": """ankle hock cannon tarsus metatarsus pastern horselink knöchel knoechel cheville tobillo
        tornozelo caviglia 足首 あしくび ashikubi asikubi 脚踝 발목""",
    "foot": """foot paw hoof fuß pied pie pé piede patte pata pezuña pfote huf sabot zampa zoccolo стопа ступня
        stopa 발""",
    "toes": """toe toes toebase ball zeh zehe zehen orteil orteils artelho alluce носок nosok tsumasaki つま先 つまさき
        足先 脚趾 脚尖 趾 발가락 발끝""",
    "wing": "wing wings feather flügel fluegel aile ala asa крыло krylo hane tsubasa 羽 翼 翅膀 날개",
    "fin": "fin fins fluke flipper flosse nageoire aleta barbatana pinna плавник hire 鰭 ひれ 지느러미",
    "upper": "upper up ober oben haut supérieur superior superiore",
    "lower": "lower low unter unten bas inférieur inferior inferiore",
    "front": "front fore vorder vorne avant delantera delantero dianteira anteriore передний передняя 前",
    "hind": "hind rear hinter hinten arrière trasera trasero traseira posteriore задний задняя 後 后",
    # Bones that do not move a part of the body by themselves: controls and targets; twists, ends, things that are worn.
    "control": "ik fk ctrl ctl control controller con pole target tgt goal aim mch",
    "other": """org tweak helper end nub null leaf socket prop weapon attach attachment anchor twist roll share
        ribbon heel tip hair skirt cloth cape bag pocket eye eyes ear ears eyelid eyelids lid brow brows lip
        lips tongue teeth cheek nose face breast bust butt glute spring physics dyn dynamic jiggle parent master
        root offset switch line handle locator dummy effector reference camera light 捩 親 目 耳 髪 スカート ボーン先 sword
        shield gun arme épée épaulière nail claw drv driver vis mute snap collider corrective""",
}
LIMB_ENDS = {"thumb", "index", "middle", "ring", "little", "finger"}
OF_ARM = LIMB_ENDS | {"girdle", "shoulder", "upper_arm", "arm", "elbow", "forearm", "hand", "wrist"}
OF_FOOT = {"ankle", "foot", "toes"}
OF_LEG = OF_FOOT | {"thigh", "leg", "leg_or_foot", "knee", "shin"}
MOST_WORDS_JOINED = 3
MOST_NAMES = 0.6  # fraction of a rig's names of body parts
ENGLISH = ("l", "r")
# The letters for left and right in French, Portuguese, Spanish and Italian. A rig has them only if it has no other marks.
SIDE_LETTERS = (ENGLISH, ("g", "d"), ("e", "d"), ("i", "d"), ("s", "d"))
_COMBINING = re.compile("[\u0300-\u036f]")
_WORD = re.compile(r"[A-Z]+(?![a-z])|[A-Z]?[a-z]+|[^\W\d_a-zA-Z]+|\d+")
_FAR_EAST = re.compile("[\u3040-\u30ff\u3400-\u9fff\uac00-\ud7af]")


@dataclass(frozen=True)
class Reading:
    """What a bone name says.

    side: "L", "R" or "". part: a key of WORDS, or "" if the name does not say it. front: it is of a foreleg. other: it is a
    control, a twist bone or something that is worn. control: it is a control or a target. unknown: the number of words
    without a meaning. rest: all words but those for the side, which a pair of bones has in common.
    """

    side: str
    part: str
    front: bool
    other: bool
    control: bool
    unknown: int
    rest: tuple[str, ...]


@functools.cache
def _meanings() -> dict[str, str]:
    return {plain(word): meaning for meaning, words in WORDS.items() for word in words.split()}


@functools.cache
def _longest_word() -> int:
    return max(map(len, _meanings()))


def plain(text: str) -> str:
    """Text without case, accents and differences of width. The marks of kana stay."""
    return unicodedata.normalize("NFC", _COMBINING.sub("", unicodedata.normalize("NFKD", text).casefold()))


def _words(name: str) -> list[str]:
    bare = re.split(r"[:|]", unicodedata.normalize("NFKC", name))[-1]
    bare = _COMBINING.sub("", unicodedata.normalize("NFD", bare)).replace("ß", "ss").replace("œ", "oe")
    bare = unicodedata.normalize("NFC", re.sub(r"(?:(?<=[^A-Za-z])|^)(IK|FK)(?=[a-z])", r"\1 ", bare))
    return [plain(word) for word in _WORD.findall(bare)]


def _split(word: str) -> list[str]:
    """The known words that a word consists of: "leftupperarm", "lshin". Empty if a part of it is unknown."""
    known = _meanings()

    def parts(rest: str, most: int) -> list[str] | None:
        if not rest:
            return []
        if most == 0:
            return None
        for length in range(min(len(rest), _longest_word()), 0, -1):
            if rest[:length] in known and (length > 2 or rest[:length] in ("l", "r", "up")):
                following = parts(rest[length:], most - 1)
                if following is not None:
                    return [rest[:length], *following]
        return None

    return parts(word, MOST_WORDS_JOINED) or []


def _split_far_east(text: str) -> list[str]:
    """The longest known words in a text that has no spaces. Unknown characters are words of their own."""
    known, found, at = _meanings(), [], 0
    while at < len(text):
        length = next((n for n in range(min(len(text) - at, _longest_word()), 0, -1) if text[at : at + n] in known), 1)
        found.append(text[at : at + length])
        at += length
    return found


def _meaning_of_words(words: list[str]) -> list[str]:
    """The meaning of each word, with neighboring words joined where the joined word is known. "" for unknown words."""
    known, found, at = _meanings(), [], 0
    while at < len(words):
        for count in range(min(MOST_WORDS_JOINED, len(words) - at), 0, -1):
            joined = "".join(words[at : at + count])
            if joined in known and (count == 1 or known[joined] not in ("left", "right")):
                found.append(known[joined])
                at += count
                break
        else:
            word = words[at]
            parts = _split_far_east(word) if _FAR_EAST.search(word) else _split(word)
            found += [known.get(part, "") for part in parts] or [""]
            at += 1
    return found


@functools.lru_cache(maxsize=4096)
def read(name: str, letters: tuple[str, str] = ENGLISH, prefixes: frozenset[str] = frozenset()) -> Reading:
    """What a bone name says.

    letters: the single letters that mark left and right besides the words of the table. prefixes: words that say nothing.
    """
    words = [word for word in _words(name) if not word.isdigit() and word not in prefixes]
    if letters != ENGLISH:
        words = [{letters[0]: "left", letters[1]: "right"}.get(word, word) for word in words]
    meanings = _meaning_of_words(words)
    sides = [meaning for meaning in meanings if meaning in ("left", "right")]
    said = set(meanings)
    return Reading(
        side={"left": "L", "right": "R"}[sides[-1]] if sides else "",
        part=_part(meanings, bool(sides)),
        front="front" in said,
        other=bool({"other", "control"} & said),
        control="control" in said,
        unknown=meanings.count(""),
        rest=_without_side(name, letters),
    )


def _without_side(name: str, letters: tuple[str, str]) -> tuple[str, ...]:
    """The words of a name and of the known words in them, but those for left and right."""
    known, rest = _meanings(), []
    for word in _words(name):
        parts = _split_far_east(word) if _FAR_EAST.search(word) else [word] if word in known else _split(word) or [word]
        rest += [part for part in parts if known.get(part) not in ("left", "right") and part not in letters]
    return tuple(rest)


def words_of(name: str) -> list[str]:
    """The words of a name, without case and accents. A text without spaces is one word."""
    return _words(name)


def prefixes_of(names: Collection[str]) -> frozenset[str]:
    """The words for control bones that say nothing: those that most names of body parts have, as "ctrl" in a rig whose
    bones are all called so. Names without a part, such as those of a skirt's bones, do not count.
    """
    known = _meanings()
    named = [set(_words(name)) for name in names if _names_part(name)]
    counts = Counter(word for words in named for word in words)
    return frozenset(
        word for word, count in counts.items() if known.get(word) in ("control", "other") and count > MOST_NAMES * len(named)
    )


def _names_part(name: str) -> bool:
    reading = read(name)
    return bool(reading.part or reading.side)


def _part(meanings: list[str], is_sided: bool) -> str:
    """The part that a name means. A leg or an arm is general: "Back Leg Ankle" is an ankle, "Leg Upper" a thigh."""
    said = set(meanings)
    legs = [meaning for meaning in meanings if meaning in OF_LEG]
    arms = [meaning for meaning in meanings if meaning in OF_ARM]
    fingers = [meaning for meaning in arms if meaning in LIMB_ENDS]
    if not is_sided:
        central = [
            meaning for meaning in meanings if meaning in ("jaw", "head", "neck", "tail", "pelvis", "hip", "trunk", "back")
        ]
        for mark in ("wing", "fin"):
            if mark in said:
                return mark
        return central[-1] if central and not legs and not arms else ""
    for mark in ("wing", "fin", "tail"):
        if mark in said:
            return mark
    if fingers and not legs:
        return next((finger for finger in fingers if finger != "finger"), "finger")
    if "pelvis" in said:
        return ""  # sided pelvis bones do not move with the thigh
    limbs = [meaning for meaning in meanings if meaning in OF_LEG | (OF_ARM - LIMB_ENDS)]
    special = [meaning for meaning in limbs if meaning not in ("leg", "leg_or_foot", "arm")]
    if special:
        return special[-1]
    if limbs:
        if limbs[-1] == "arm":
            return "upper_arm" if "upper" in said else "forearm" if "lower" in said else "arm"
        return "thigh" if "upper" in said else "shin" if "lower" in said else limbs[-1]
    return "hip" if "hip" in said else ""
