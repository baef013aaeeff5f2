"""Paints of few layers, the reference's samples among them."""

from ...engine.paint.reader import parse_paint


def make_paint(layers, reflectance=0.0, **own):
    """A paint of layers (thickness in um, flakes, pigments, binder index)."""
    made = [
        {
            "thickness_um": thickness,
            "binder": {"index": index},
            "flakes": flakes,
            "pigments": pigments,
        }
        for thickness, flakes, pigments, index in layers
    ]
    content = {"lumenray_paint": 1, "name": "Test", "layers": made}
    return parse_paint(content | {"substrate": {"reflectance": reflectance}} | own)


def one_layer(flakes, reflectance=0.0, thickness=20, pigments=(), index=1.45):
    return make_paint([(thickness, list(flakes), list(pigments), index)], reflectance)


def mirrors(reflectance, tilt, area=0.1, transmittance=0.0, **own):
    """Flakes that reflect, and perhaps let pass, the same at all angles."""
    mirror = {"reflectance": reflectance, "transmittance": transmittance}
    amount = {"area_per_volume_per_um": area}
    return {"mirror": mirror, "amount": amount, "tilt_deg": tilt} | own


def interference(core, core_index, coating, area, tilt=3, **own):
    """Flakes of a core with titania of the index 2.7 on both faces, thicknesses in nm."""
    stack = {
        "core": {"index": core_index, "thickness_nm": core},
        "coatings": [{"index": 2.7, "thickness_nm": coating}],
    }
    return {"stack": stack, "amount": {"area_per_volume_per_um": area}, "tilt_deg": tilt} | own


def sample(number: int):
    """One of the reference's three samples; of the third all amounts are ours."""
    if number == 1:
        flakes = interference(448, 1.5, 12, 0.0)
        flakes |= {"amount": {"binder_mass_ratio": 0.24}, "density_g_per_cm3": 2.7}
        return one_layer([flakes])
    if number == 2:
        flakes = interference(230, 1.77, 165, 0.0)
        flakes |= {"amount": {"mass_fraction": 0.073}, "density_g_per_cm3": 3.7}
        return one_layer([flakes], 0.2)
    green = interference(230, 1.77, 60, 0.017512500446808656, 4)
    return one_layer([green, interference(300, 1.77, 60, 0.03502500089361731, 4)], 0.95)
