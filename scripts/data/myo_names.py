"""The anatomical names of the muscles of the myofullbody model, and the strands that form one belly.

The table holds (pattern, name, belly, group). The groups of the pattern fill "{0}" and "{1}" in the name. An empty belly
means that the muscle is a belly by itself. The strands of a belly are side by side, so that one ellipsoid represents them.
"""

import re

_MUSCLES = (
    (r"Ps_(\w+?)_(.+)", "Psoas major, {0} {1}", "Psoas major", "trunk"),
    (r"psoas", "Psoas major, femoral part", "", "hip"),
    (r"iliacus", "Iliacus", "", "hip"),
    (r"rect_abd", "Rectus abdominis", "", "abdomen"),
    (r"IL_(L\d)", "Iliocostalis lumborum, {0}", "Iliocostalis lumborum, lumbar part", "back"),
    (r"IL_R([5-8])", "Iliocostalis lumborum, rib {0}", "Iliocostalis lumborum, upper thoracic part", "back"),
    (r"IL_R(\d+)", "Iliocostalis lumborum, rib {0}", "Iliocostalis lumborum, lower thoracic part", "back"),
    (r"LTpT_T([1-6])", "Longissimus thoracis, T{0}", "Longissimus thoracis, upper part", "back"),
    (r"LTpT_T(\d+)", "Longissimus thoracis, T{0}", "Longissimus thoracis, lower part", "back"),
    (r"LTpT_R([4-8])", "Longissimus thoracis, rib {0}", "Longissimus thoracis, upper costal part", "back"),
    (r"LTpT_R(\d+)", "Longissimus thoracis, rib {0}", "Longissimus thoracis, lower costal part", "back"),
    (r"LTpL_(L\d)", "Longissimus thoracis, lumbar {0}", "Longissimus thoracis, lumbar part", "back"),
    (r"QL_(post|mid|ant)_(.+)", "Quadratus lumborum, {0} {1}", "Quadratus lumborum", "back"),
    (r"MF_(.+)", "Multifidus, {0}", "Multifidus", "back"),
    (r"EO([1-3])", "External oblique, {0}", "External oblique, anterior part", "abdomen"),
    (r"EO([4-6])", "External oblique, {0}", "External oblique, lateral part", "abdomen"),
    (r"IO([1-3])", "Internal oblique, {0}", "Internal oblique, anterior part", "abdomen"),
    (r"IO([4-6])", "Internal oblique, {0}", "Internal oblique, lateral part", "abdomen"),
    (r"DELT1", "Deltoid, clavicular part", "", "shoulder"),
    (r"DELT2", "Deltoid, acromial part", "", "shoulder"),
    (r"DELT3", "Deltoid, spinal part", "", "shoulder"),
    (r"SUPSP", "Supraspinatus", "", "shoulder"),
    (r"INFSP", "Infraspinatus", "", "shoulder"),
    (r"SUBSC", "Subscapularis", "", "shoulder"),
    (r"TMIN", "Teres minor", "", "shoulder"),
    (r"TMAJ", "Teres major", "", "shoulder"),
    (r"CORB", "Coracobrachialis", "", "shoulder"),
    (r"PECM1", "Pectoralis major, clavicular part", "", "chest"),
    (r"PECM2", "Pectoralis major, sternal part", "Pectoralis major, sternocostal part", "chest"),
    (r"PECM3", "Pectoralis major, costal part", "Pectoralis major, sternocostal part", "chest"),
    (r"LAT1", "Latissimus dorsi, thoracic part", "", "back"),
    (r"LAT2", "Latissimus dorsi, lumbar part", "Latissimus dorsi, lumbar part", "back"),
    (r"LAT3", "Latissimus dorsi, iliac part", "Latissimus dorsi, lumbar part", "back"),
    (r"TRIlong", "Triceps brachii, long head", "", "arm"),
    (r"TRIlat", "Triceps brachii, lateral head", "", "arm"),
    (r"TRImed", "Triceps brachii, medial head", "", "arm"),
    (r"ANC", "Anconeus", "", "arm"),
    (r"BIClong", "Biceps brachii, long head", "", "arm"),
    (r"BICshort", "Biceps brachii, short head", "", "arm"),
    (r"BRA", "Brachialis", "", "arm"),
    (r"BRD", "Brachioradialis", "", "forearm"),
    (r"SUP", "Supinator", "", "forearm"),
    (r"ECRL", "Extensor carpi radialis longus", "", "forearm"),
    (r"ECRB", "Extensor carpi radialis brevis", "", "forearm"),
    (r"ECU", "Extensor carpi ulnaris", "", "forearm"),
    (r"FCR", "Flexor carpi radialis", "", "forearm"),
    (r"FCU", "Flexor carpi ulnaris", "", "forearm"),
    (r"PL", "Palmaris longus", "", "forearm"),
    (r"PT", "Pronator teres", "", "forearm"),
    (r"PQ", "Pronator quadratus", "", "forearm"),
    (r"FDS([2-5])", "Flexor digitorum superficialis, finger {0}", "Flexor digitorum superficialis", "forearm"),
    (r"FDP([2-5])", "Flexor digitorum profundus, finger {0}", "Flexor digitorum profundus", "forearm"),
    (r"EDC([2-5])", "Extensor digitorum, finger {0}", "Extensor digitorum", "forearm"),
    (r"EDM", "Extensor digiti minimi", "", "forearm"),
    (r"EIP", "Extensor indicis", "", "forearm"),
    (r"EPL", "Extensor pollicis longus", "", "forearm"),
    (r"EPB", "Extensor pollicis brevis", "", "forearm"),
    (r"FPL", "Flexor pollicis longus", "", "forearm"),
    (r"APL", "Abductor pollicis longus", "", "forearm"),
    (r"OP", "Opponens pollicis", "", "hand"),
    (r"RI([2-5])", "Radial interosseus, finger {0}", "", "hand"),
    (r"UI_UB([2-5])", "Ulnar interosseus, finger {0}", "", "hand"),
    (r"LU_RB([2-5])", "Lumbrical, finger {0}", "", "hand"),
    (r"addbrev", "Adductor brevis", "", "hip"),
    (r"addlong", "Adductor longus", "", "hip"),
    (r"addmag(Dist|Isch|Mid|Prox)", "Adductor magnus, {0}", "Adductor magnus", "hip"),
    (r"glmax([1-3])", "Gluteus maximus, {0}", "", "hip"),
    (r"glmed([1-3])", "Gluteus medius, {0}", "", "hip"),
    (r"glmin([1-3])", "Gluteus minimus, {0}", "Gluteus minimus", "hip"),
    (r"piri", "Piriformis", "", "hip"),
    (r"tfl", "Tensor fasciae latae", "", "hip"),
    (r"bflh", "Biceps femoris, long head", "", "thigh"),
    (r"bfsh", "Biceps femoris, short head", "", "thigh"),
    (r"grac", "Gracilis", "", "thigh"),
    (r"sart", "Sartorius", "", "thigh"),
    (r"recfem", "Rectus femoris", "", "thigh"),
    (r"semimem", "Semimembranosus", "", "thigh"),
    (r"semiten", "Semitendinosus", "", "thigh"),
    (r"vasint", "Vastus intermedius", "", "thigh"),
    (r"vaslat", "Vastus lateralis", "", "thigh"),
    (r"vasmed", "Vastus medialis", "", "thigh"),
    (r"edl", "Extensor digitorum longus", "", "leg"),
    (r"ehl", "Extensor hallucis longus", "", "leg"),
    (r"fdl", "Flexor digitorum longus", "", "leg"),
    (r"fhl", "Flexor hallucis longus", "", "leg"),
    (r"gaslat", "Gastrocnemius, lateral head", "", "leg"),
    (r"gasmed", "Gastrocnemius, medial head", "", "leg"),
    (r"perbrev", "Fibularis brevis", "", "leg"),
    (r"perlong", "Fibularis longus", "", "leg"),
    (r"soleus", "Soleus", "", "leg"),
    (r"tibant", "Tibialis anterior", "", "leg"),
    (r"tibpost", "Tibialis posterior", "", "leg"),
)


def name_of(model_name: str) -> str:
    """The anatomical name of a muscle of the model (such as "ECRL_l")."""
    found, (_, name, _, _) = _entry(model_name)
    return name.format(*(part.replace("_", " ") for part in found.groups()))


def belly_of(model_name: str) -> str:
    """The name of the belly that a strand belongs to; empty if the muscle is a belly by itself."""
    return _entry(model_name)[1][2]


def group_of(model_name: str) -> str:
    """The region of the body."""
    return _entry(model_name)[1][3]


def _entry(model_name: str):
    plain = model_name.removesuffix("_l")
    for entry in _MUSCLES:
        found = re.fullmatch(entry[0], plain)
        if found:
            return found, entry
    raise KeyError(f"No anatomical name for '{model_name}'")
