"""A device is taken when it computes rightly, and kernels keep to what every device can do."""

import re
import sys
from dataclasses import replace

import numpy as np
import pytest
from baking_rooms import bake_in, furnished_room, lamp
from small_scenes import paint, quad, session_of

from lumenray.engine import device_trial, llvm
from lumenray.engine.accuracy.stopping import StopRule
from lumenray.engine.errors import BackendError
from lumenray.engine.scene.camera import Camera, Projection
from lumenray.engine.scene.light import Output, PointLight, Quantity, SunLight, UniformWorld
from lumenray.engine.scene.material import Coated, Dielectric, Diffuse, Glossy, Material, Mix
from lumenray.engine.scene.spectrum import Constant, Rgb
from lumenray.engine.transport import backend, device_check, devices
from lumenray.engine.views import ViewSettings


@pytest.fixture(autouse=True)
def _fresh(monkeypatch):
    """Let each test choose anew."""
    monkeypatch.delenv(devices.CHOICE, raising=False)
    backend._device.cache_clear()
    yield
    backend._device.cache_clear()


@pytest.fixture
def card(monkeypatch):
    """Put a graphics card into this machine: the processor's own variants under another name."""
    made = replace(
        devices.DEVICES["cuda"], label="A card", prefix="llvm_ad", backend="LLVM", is_trusted=True
    )
    monkeypatch.setitem(devices.DEVICES, "cuda", made)
    monkeypatch.setitem(devices._DESCRIPTIONS, "cuda", lambda: "A card, driver 1")
    return made


def wrong(variant):
    return device_check.Check("sums of integers are wrong", 1e6, 0.1)


def test_the_processor_passes_its_check_and_is_named():
    told = backend.status()
    assert told.usable
    assert told.device == "cpu"
    assert "LLVM" in told.found[0]
    assert "million rays a second" in told.found[0]
    assert backend.start(spectral=False) == "llvm_ad_mono"
    assert backend.start(spectral=True) == "llvm_ad_spectral"


def test_a_card_that_computes_rightly_goes_first(card):
    told = backend.status()
    assert told.device == "cuda"
    assert told.cause.endswith("A card, driver 1")
    assert backend._device("") is card


def test_a_card_that_computes_wrongly_is_not_taken_and_told(card, monkeypatch, caplog):
    right = device_check.check_variant
    results = [wrong(""), right("llvm_ad_mono"), wrong("")]
    monkeypatch.setattr(backend, "check_variant", lambda _: results.pop(0))
    told = backend.status()
    assert told.device == "cpu"
    assert told.found[0] == "A card, driver 1: sums of integers are wrong"
    assert backend._device("").key == "cpu"
    assert "sums of integers are wrong" in caplog.text


def test_a_card_that_is_not_trusted_is_taken_only_when_chosen_and_results_say_so(card, monkeypatch):
    made = replace(card, is_trusted=False)
    monkeypatch.setitem(devices.DEVICES, "cuda", made)
    assert backend.status().device == "cpu"
    monkeypatch.setenv(devices.CHOICE, "cuda")
    assert backend.status().device == "cuda"
    assert backend._device("cuda") is made
    backend.start(spectral=False)
    session = session_of(paint(0.5), quad("floor", (0, 0, 0), (1, 0, 0), (0, 1, 0), "paint"))
    made = session.measure([[0.0, 0.0, 1.0]], [[0.0, 0.0, 1.0]], StopRule(samples=64), 1)
    assert any("computed on A card" in note for note in made.provenance.notes)


def test_a_card_that_was_chosen_and_computes_wrongly_computes_nothing(card, monkeypatch):
    monkeypatch.setenv(devices.CHOICE, "cuda")
    monkeypatch.setattr(backend, "check_variant", wrong)
    with pytest.raises(BackendError, match="A card is not used: sums of integers are wrong"):
        backend._device("cuda")


def test_a_card_that_finds_one_layer_of_two_in_a_kernel_is_found_out(monkeypatch):
    from lumenray.engine.transport import layers

    # What OptiX does to a second scene in a kernel.
    real, traced = layers.SharedLayer.ray_test, []

    def trace(layer, ray, active=True):
        traced.append(layer)
        return real(layer, ray, active) if layer is traced[0] else layers.mi.Bool(False)

    monkeypatch.setattr(layers.SharedLayer, "ray_test", trace)
    monkeypatch.setitem(devices.DEVICES, "cpu", replace(devices.DEVICES["cpu"], traces_many=False))
    assert "two layers" in device_check.check_variant("llvm_ad_mono").fault


def test_an_answer_without_a_usable_error_is_not_right():
    assert not device_trial.Answer("bake", 41.667, 83.333, 41.667, "lx", 1.0).is_right
    assert device_trial.Answer("bake", 83.3, 83.333, 0.14, "lx", 1.0).is_right


def test_a_card_that_was_chosen_is_not_replaced_by_another(card, monkeypatch):
    monkeypatch.setenv(devices.CHOICE, "cuda")
    monkeypatch.setattr(backend, "check_variant", wrong)
    told = backend.status()
    assert not told.usable
    assert "sums of integers are wrong" in told.cause
    assert "Automatic" in told.remedy


@pytest.mark.parametrize(("key", "said"), [("metal", "Apple GPU"), ("abacus", "'abacus'")])
def test_a_choice_that_is_not_there_is_refused_with_the_remedy(key, said, monkeypatch):
    monkeypatch.setenv(devices.CHOICE, key)
    told = backend.status()
    assert not told.usable
    assert said in told.cause
    assert told.remedy
    with pytest.raises(BackendError, match=said):
        backend.start(spectral=False)


FAULTY = """
from pathlib import Path
with Path(__file__).with_name("tries").open("a") as tries:
    tries.write("try ")
try:
    from . import _no_such_library as _library
except ImportError:
    raise OSError(f"cannot import {_library.__file__}")
"""


@pytest.fixture
def faulty_drjit(monkeypatch, tmp_path):
    """Put a Dr.Jit into the way that does not load, and says so as wrongly as the real one; return its folder."""
    folder = tmp_path / "drjit"
    folder.mkdir()
    (folder / "__init__.py").write_text(FAULTY)
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.delitem(sys.modules, "drjit")
    backend._load.cache_clear()
    yield folder
    backend._load.cache_clear()


def test_libraries_that_do_not_load_are_told_by_the_first_cause_and_not_tried_again(faulty_drjit):
    told = backend.status()
    assert not told.usable
    assert "cannot import name '_no_such_library'" in told.cause
    assert "reinstall" in told.remedy
    with pytest.raises(BackendError, match="_no_such_library"):
        backend.start(spectral=False)
    assert (faulty_drjit / "tries").read_text() == "try "


def test_without_room_nothing_is_loaded(faulty_drjit, monkeypatch):
    monkeypatch.setattr(backend, "ROOM", 1 << 60)
    assert "memory left for the engine's libraries" in backend.status().cause
    assert not (faulty_drjit / "tries").exists()


def test_an_llvm_that_dr_jit_cannot_use_is_named(monkeypatch):
    monkeypatch.setattr(devices.Device, "is_present", lambda _: False)
    told = backend.status()
    assert not told.usable
    assert told.cause == f"Dr.Jit cannot use the LLVM library '{llvm.find_library()}'"


def test_the_check_finds_what_a_faulty_device_would_do(monkeypatch):
    import drjit as dr

    monkeypatch.setattr(dr, "sqrt", lambda x: x * 0.5)
    assert "square roots" in device_check.check_variant("llvm_ad_mono").fault
    monkeypatch.undo()
    monkeypatch.setattr(device_check, "_cone", lambda *_: box_shape(0.2))
    assert "rays through two layers met" in device_check.check_variant("llvm_ad_mono").fault
    monkeypatch.setattr(device_check, "_check_layers", lambda variant: "")
    assert device_check.check_variant("llvm_ad_mono").fault.startswith("rays met")


def box_shape(scale):
    import mitsuba as mi

    return mi.load_dict({"type": "cube", "to_world": mi.ScalarTransform4f().scale(scale)})


@pytest.mark.parametrize("kind", ["mono", pytest.param("spectral", marks=pytest.mark.slow)])
def test_jobs_with_known_answers_are_right_on_the_processor(kind):
    answers = list(device_trial.try_jobs(kind))
    assert [one.job for one in answers] == ["measure", "bake", "render"]
    assert all(one.is_right for one in answers), answers
    assert not any(replace(one, value=one.value * 1.02).is_right for one in answers)


# ---- what kernels are made of ----

SURFACES = {
    "diffuse": Diffuse(Rgb(0.2, 0.5, 0.7)),
    "coat": Coated(Constant(0.6), 1.5, 0.1),
    "mirror": Glossy(Constant(0.8), 0.0),
    "rough metal": Glossy(Constant(0.8), 0.2),
    "glass": Dielectric(),
    "mixture": Mix(Diffuse(Constant(0.4)), Glossy(Constant(0.9), 0.1), 0.5),
}

LIGHTS = {
    "point": PointLight("l", "l", Output(Quantity.LUMINOUS_FLUX, 500.0), np.array([1.0, 1.0, 1.5])),
    "ball": lamp([1.0, 1.0, 1.5]),
    "sun": SunLight("l", "l", Output(Quantity.ILLUMINANCE, 1e4), np.array([0.0, 0.0, -1.0]), 0.009),
    "sky": UniformWorld(1000.0),
}


def kernels():
    """Return the text of every kernel since the history was cleared."""
    import drjit as dr

    return [entry["ir"].getvalue() for entry in dr.kernel_history() if "ir" in entry]


@pytest.mark.slow
@pytest.mark.parametrize("light", LIGHTS)
def test_no_kernel_computes_in_double_precision(light):
    """Metal has none, and graphics cards have it thirty times slower."""
    import drjit as dr

    backend.start(spectral=True)
    dr.set_flag(dr.JitFlag.KernelHistory, True)
    dr.kernel_history_clear()
    try:
        things = [Material(name, name, surface) for name, surface in SURFACES.items()]
        shelves = [
            quad(f"shelf {number}", (0.2, 0.2, 0.2 + 0.2 * number), (0.3, 0, 0), (0, 0.3, 0), name)
            for number, name in enumerate(SURFACES)
        ]
        session = session_of(*furnished_room(), paint(0.5), LIGHTS[light], *things, *shelves)
        session.measure([[1, 1, 1]], [[0, 0, 1.0]], StopRule(samples=64), 0, "spectral")
        frame = np.eye(4)
        frame[:3, 3] = 1.0, 1.0, 1.9
        camera = Camera(frame, Projection.PERSPECTIVE, 16, 16)
        session.render(camera, ViewSettings(StopRule(samples=4), transport="spectral"))
        bake_in(session, ("room",), 16)
        texts = kernels()
    finally:
        dr.set_flag(dr.JitFlag.KernelHistory, False)
        dr.kernel_history_clear()
    assert len(texts) > 10
    lines = [line for text in texts for line in text.splitlines() if re.search(r"\bdouble\b", line)]
    assert lines == []
