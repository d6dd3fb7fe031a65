"""The 40 muscles of a leg whose volumes were measured, and the names that the preset human has for them."""

# volume in cm3 of one side, of a man of 75 kg whose body has 75 l: maximum isometric force times optimal fibre length over
# 60 N/cm2, of Rajagopal et al., IEEE TBME 63(10), 2016, whose volumes are from MRI of 24 adults (Handsfield et al. 2014)
MEASURED_CM3 = {
    "Adductor brevis": 107.5,
    "Adductor longus": 165.3,
    "Adductor magnus, distal part": 176.4,
    "Adductor magnus, ischial part": 155.5,
    "Adductor magnus, middle part": 137.1,
    "Adductor magnus, proximal part": 105.1,
    "Biceps femoris, long head": 213.6,
    "Biceps femoris, short head": 102.4,
    "Extensor digitorum longus": 69.7,
    "Extensor hallucis longus": 35.6,
    "Flexor digitorum longus": 31.5,
    "Flexor hallucis longus": 79.7,
    "Gastrocnemius, lateral head": 154.4,
    "Gastrocnemius, medial head": 264.8,
    "Gluteus maximus, upper part": 241.0,
    "Gluteus maximus, middle part": 367.9,
    "Gluteus maximus, lower part": 263.8,
    "Gluteus medius, anterior part": 133.0,
    "Gluteus medius, middle part": 93.1,
    "Gluteus medius, posterior part": 106.0,
    "Gluteus minimus, anterior part": 42.4,
    "Gluteus minimus, middle part": 36.8,
    "Gluteus minimus, posterior part": 28.3,
    "Gracilis": 106.8,
    "Iliacus": 181.4,
    "Fibularis brevis": 39.4,
    "Fibularis longus": 94.4,
    "Piriformis": 44.6,
    "Psoas major": 278.0,
    "Rectus femoris": 277.3,
    "Sartorius": 167.5,
    "Semimembranosus": 253.1,
    "Semitendinosus": 190.2,
    "Soleus": 454.3,
    "Tensor fasciae latae": 65.1,
    "Tibialis anterior": 139.7,
    "Tibialis posterior": 109.0,
    "Vastus intermedius": 280.9,
    "Vastus lateralis": 853.0,
    "Vastus medialis": 443.3,
}
BODY_OF_MEASURED_M3 = 0.075


def ratios(volumes_m3: dict[str, float], body_m3: float) -> dict[str, float]:
    """By muscle: the volume of its left belly over the measured one, scaled to a body of this volume. 0 if it is missing."""
    scale = 1e-6 * body_m3 / BODY_OF_MEASURED_M3
    return {name: volumes_m3.get(f"{name}.L", 0.0) / (scale * measured) for name, measured in MEASURED_CM3.items()}
