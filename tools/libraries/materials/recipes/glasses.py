"""Clear matter: optical glass, crystals, water, plastics, panes."""

from ..indices import CLEAR, LINES, abbe_number, cauchy_of
from .recipe import Recipe


def recipes() -> list[Recipe]:
    """Return all clear matter."""

    def solid(name, kind, key, title, what, source, *tags):
        a, b = cauchy_of(CLEAR[key])
        settings = {
            "model": "DIELECTRIC",
            "ior_source": "CAUCHY",
            "ior": round(a, 6),
            "cauchy_b": round(b, 7),
            "roughness": 0.0,
        }
        return Recipe(
            name, kind, title, what, f"{source}; Cauchy's formula with the same n_d and Abbe number",
            ("clear", "refraction", *tags), settings,
            more={
                "refractive_index_d": round(float(CLEAR[key].index(LINES["d"])), 5),
                "abbe_number": round(abbe_number(CLEAR[key]), 2),
            },
        )  # fmt: skip

    def pane(name, title, what, internal, target, *tags):
        settings = {
            "model": "THIN_GLASS",
            "ior_source": "CONSTANT",
            "ior": round(float(CLEAR["float glass"].index(LINES["d"])), 4),
            "transmittance": internal,
        }
        return Recipe(
            name, "Glass/Panes", title, what,
            "Index of soda-lime glass (Rubin 1985), internal transmittance from the luminous one usual for the kind",
            ("glass", "window", "pane", *tags), settings, reflectance=0.08, transmittance=target,
        )  # fmt: skip

    optical, liquid, plastic = "Glass/Optical", "Liquid", "Plastic/Clear"
    return [
        solid("glass_n_bk7", optical, "N-BK7", "N-BK7", "Borosilicate crown for lenses and prisms.",
              "Sellmeier coefficients of Schott's data sheet", "glass", "crown"),
        solid("glass_n_sf11", optical, "N-SF11", "N-SF11",
              "Dense flint with strong dispersion; below 450 nm the index is up to 0.007 low.",
              "Sellmeier coefficients of Schott's data sheet", "glass", "flint", "dispersion"),
        solid("glass_fused_silica", optical, "fused silica", "Fused silica", "Pure quartz glass.",
              "Malitson 1965", "glass", "quartz"),
        solid("sapphire", "Crystal", "sapphire", "Sapphire", "Ordinary ray; double refraction is left out.",
              "Malitson 1962", "crystal"),
        solid("diamond", "Crystal", "diamond", "Diamond", "Brilliant: high index and fire.", "Peter 1923",
              "crystal", "jewel", "dispersion"),
        solid("water", liquid, "water", "Water", "Pure, at 20 °C.", "Daimon and Masumura 2007", "liquid"),
        solid("acrylic_clear", plastic, "PMMA", "Acrylic, clear", "PMMA of light guides and lenses.",
              "Sultanova et al. 2009", "plastic", "PMMA", "lens"),
        solid("polycarbonate_clear", plastic, "polycarbonate", "Polycarbonate, clear", "Lenses and covers.",
              "Sultanova et al. 2009", "plastic", "lens"),
        pane("pane_float_4mm", "Float glass, 4 mm", "Single clear pane.", 0.98, 0.90, "float"),
        pane("pane_low_iron_4mm", "Low-iron glass, 4 mm", "Extra clear pane, without the green of iron.", 0.996, 0.91,
             "low iron"),
    ]  # fmt: skip
