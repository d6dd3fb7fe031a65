"""Makes scripts/data/path_lengths.json: lengths of muscles of the myofullbody model while a joint bends.

usage: python scripts/data/make_path_lengths.py, with a Python that has mujoco, dm_control and myo_sim 0.2.4 from PyPI

The model is under Apache-2.0. Its muscles wrap around bones as in OpenSim's models. Couplings of joints, such as the
sliding of a knee, are applied. All other joints are at rest.
"""

import json
from pathlib import Path

import mujoco
import myo_sim
import numpy as np

TARGET = Path(__file__).with_name("path_lengths.json")
STEP = 10  # degrees
SIDE = "_r"
# joint in Sinew's measurements: joint of the model, last degree, the bodies at both ends of the limb that scales lengths
JOINTS = {
    "hip": ("hip_flexion_r", 110, ("femur_r", "tibia_r")),
    "knee": ("knee_angle_r", 120, ("femur_r", "tibia_r")),
    "elbow": ("elbow_flexion_r", 130, ("humerus_r", "ulna_r")),
}
LEAST_CHANGE_M = 0.001


def main() -> None:
    model, data = myo_sim.load("myofullbody")

    def named(kind, count: int) -> list[str]:
        return [mujoco.mj_id2name(model, kind, index) for index in range(count)]

    joints, tendons = named(mujoco.mjtObj.mjOBJ_JOINT, model.njnt), named(mujoco.mjtObj.mjOBJ_TENDON, model.ntendon)
    couplings = [
        (model.eq_obj1id[index], model.eq_obj2id[index], model.eq_data[index][:5])
        for index in range(model.neq)
        if model.eq_type[index] == mujoco.mjtEq.mjEQ_JOINT
    ]

    def lengths_m(joint: str, degrees: float) -> np.ndarray:
        mujoco.mj_resetData(model, data)
        data.qpos[model.jnt_qposadr[joints.index(joint)]] = np.radians(degrees)
        for follower, leader, polynomial in couplings:
            at = model.jnt_qposadr[[follower, leader]]
            angle = 0.0 if leader < 0 else data.qpos[at[1]] - model.qpos0[at[1]]
            data.qpos[at[0]] = model.qpos0[at[0]] + np.polyval(polynomial[::-1], angle)
        mujoco.mj_kinematics(model, data)
        mujoco.mj_comPos(model, data)
        mujoco.mj_tendon(model, data)
        return data.ten_length.copy()

    found = {}
    for name, (joint, last, (upper, lower)) in JOINTS.items():
        lengths = np.array([lengths_m(joint, degrees) for degrees in range(0, last + 1, STEP)])
        lengths_m(joint, 0)
        limb = np.linalg.norm(data.body(upper).xpos - data.body(lower).xpos)
        names = [tendon.removesuffix("_tendon") for tendon in tendons]
        muscles = {
            muscle.removesuffix(SIDE): np.round(1000 * lengths[:, index], 1).tolist()
            for index, muscle in enumerate(names)
            if not muscle.endswith("_l") and "ligament" not in muscle and np.ptp(lengths[:, index]) > LEAST_CHANGE_M
        }
        found[name] = {"limb_mm": round(1000 * limb, 1), "step_degrees": STEP, "lengths_mm": muscles}
    source = "PyPI myo_sim 0.2.4, model myofullbody, Apache-2.0, by scripts/data/make_path_lengths.py"
    TARGET.write_text(json.dumps({"source": source, "joints": found}, separators=(",", ":")) + "\n")


if __name__ == "__main__":
    main()
