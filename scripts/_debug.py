import sys, importlib.util, math
sys.argv=['x','/work/unseen/'+sys.argv[1],*sys.argv[2:]]
spec=importlib.util.spec_from_file_location('harm','/work/wt/tools/harm.py'); H=importlib.util.module_from_spec(spec); spec.loader.exec_module(H)
import bpy, numpy as np
from mathutils import Matrix, Euler
path, muscles, bone, axis, deg = sys.argv[1:6]
rig, skins = H.load(path)
H.make_active(rig)
getattr(bpy.ops.sinew,'add_automatic')() if muscles=='auto' else bpy.ops.sinew.add_preset(name=muscles)
for s in skins:
    H.make_active(s); bpy.ops.sinew.bind(); s.sinew.skin.live=True
pb=rig.pose.bones[bone]
print('parent',pb.parent and pb.parent.name,'children',[c.name for c in pb.children], 'constraints',[c.type for c in pb.constraints])
for s in skins:
    surf=None
for live in (False,True,'unsafe'):
    for s in skins:
        s.sinew.skin.live=bool(live)
        if live=='unsafe': s.sinew.skin.safeguards=False
    pb.matrix_basis=Matrix.Rotation(math.radians(float(deg)),4,axis)
    bpy.context.view_layer.update()
    for s in skins:
        x=H.points(s)
        if live is False: s['x']=x.tolist(); continue
        a=np.array(s['x']); d=np.linalg.norm(x-a,axis=1)
        names={g.index:g.name for g in s.vertex_groups}
        i=int(d.argmax())
        print(live, s.name,len(d),'max diff',d.max(),'moved',(d>1e-5*np.ptp(a,axis=0).max()).sum(),'size',np.ptp(a,axis=0).max(), 'worst vertex weights',[(names[g.group],round(g.weight,3)) for g in s.data.vertices[i].groups])
