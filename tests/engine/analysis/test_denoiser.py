"""Noise filtered for looking at: by Open Image Denoise where it is there; else the picture stays, and that is told."""

from types import SimpleNamespace

import numpy as np
import pytest

from lumenray.engine.analysis import denoiser
from lumenray.engine.analysis.block_means import BLOCK, block_means, keep_means
from lumenray.engine.analysis.looking import filter_noise
from lumenray.engine.photometry.colour import REC709_LUMINANCE

needs_denoiser = pytest.mark.skipif(
    denoiser.find_denoiser() is None, reason="Open Image Denoise (pyoidn) is not installed"
)


def striped_walls(scale=1.0):
    """Two walls with stripes, as they are and with noise, and the picture that holds normals and albedo."""
    rng = np.random.default_rng(7)
    height, width = 96, 160
    light = np.full((height, width, 1), 0.5)
    light[:, 80:] = 0.2
    normal = np.zeros((height, width, 3), np.float32)
    normal[:, :80, 2] = normal[:, 80:, 0] = 1.0
    stripes = np.where(np.arange(width) // 8 % 2 == 0, 0.8, 0.2)
    albedo = np.broadcast_to(stripes[None, :, None], (height, width, 3)).astype(np.float32)
    clean = scale * light * albedo
    noisy = clean * (1.0 + 0.3 * rng.normal(size=(height, width, 1)))
    picture = SimpleNamespace(denoising_normal=normal, denoising_albedo=albedo)
    return clean, noisy, picture


def deviation(made, clean):
    """Root mean square deviation as a share of the mean."""
    return np.sqrt(((made - clean) ** 2).mean()) / clean.mean()


def largest_shift(made, raw):
    """Largest relative difference between means of luminance in blocks."""
    means = [block_means(each @ REC709_LUMINANCE) for each in (made, raw)]
    return np.abs(means[0] / means[1] - 1.0).max()


@needs_denoiser
@pytest.mark.parametrize("scale", [1.0, 1e5, 1e-4])
def test_the_denoiser_takes_noise_out_in_any_unit_but_no_light(scale):
    clean, noisy, picture = striped_walls(scale)
    made = filter_noise(noisy, picture)
    assert (made.words, made.problem) == ("denoised by Open Image Denoise", "")
    assert deviation(made.colour, clean) < 0.15 * deviation(noisy, clean)
    assert largest_shift(made.colour, noisy) < 0.01


@needs_denoiser
def test_the_same_picture_is_denoised_the_same():
    _, noisy, picture = striped_walls()
    first, second = (filter_noise(noisy, picture).colour for _ in range(2))
    np.testing.assert_array_equal(first, second)


@needs_denoiser
def test_noise_of_the_guides_does_not_get_into_a_blurred_picture():
    clean, noisy, picture = striped_walls()
    grain = np.random.default_rng(1).normal(size=(*clean.shape[:2], 1))
    picture.denoising_albedo = np.clip(picture.denoising_albedo * (1.0 + 0.3 * grain), 0.0, 1.0)
    sharp, blurred = (
        deviation(filter_noise(noisy, picture, is_blurred=flag).colour, clean)
        for flag in (False, True)
    )
    assert blurred < 0.7 * sharp


@needs_denoiser
def test_maps_of_light_are_denoised_without_guides():
    rng = np.random.default_rng(3)
    slope = np.linspace(100.0, 500.0, 128)
    clean = np.broadcast_to(slope[None, :, None], (96, 128, 3))
    noisy = clean * (1.0 + 0.1 * rng.normal(size=(96, 128, 1)))
    assert deviation(denoiser.denoise_map(noisy), clean) < 0.3 * deviation(noisy, clean)


@needs_denoiser
def test_black_and_faulty_pixels_do_no_harm():
    _, noisy, picture = striped_walls()
    guides = picture.denoising_normal, picture.denoising_albedo
    assert denoiser.denoise(np.zeros_like(noisy), *guides).max() < 1e-4
    noisy[5, 5], noisy[6, 6], noisy[7, 7] = np.nan, np.inf, -1.0
    made = denoiser.denoise(noisy, *guides)
    assert np.isfinite(made).all()
    assert made.min() >= 0.0
    assert made[40:].max() < 1.0


@needs_denoiser
def test_a_task_that_is_not_wanted_any_more_ends():
    _, noisy, picture = striped_walls()
    task = denoiser.Denoising(noisy, picture.denoising_normal, picture.denoising_albedo)
    task.cancel()
    assert task.wait(0.0)
    with pytest.raises(denoiser.DenoiserError, match="ended with"):
        task.result()


def test_where_it_is_not_installed_the_picture_stays_as_computed(monkeypatch):
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    _, noisy, picture = striped_walls()
    made = filter_noise(noisy, picture)
    assert made.words == ""
    assert made.problem.startswith(
        "Open Image Denoise is not installed: install the zip lumenray-denoiser"
    )
    assert made.problem.endswith("; the picture is shown as computed")
    np.testing.assert_array_equal(made.colour, noisy)


def test_a_library_that_does_not_load_is_told_in_a_sentence(monkeypatch, tmp_path):
    broken = tmp_path / "libOpenImageDenoise.so"
    broken.write_bytes(b"no library")
    monkeypatch.setattr(denoiser, "find_denoiser", lambda: broken)
    _, noisy, picture = striped_walls()
    made = filter_noise(noisy, picture)
    assert made.problem.startswith("Open Image Denoise ended with 1: OSError")
    assert str(broken) in made.problem


@pytest.mark.parametrize("shape", [(96, 160), (70, 33), (20, 20)])
def test_blocks_keep_their_means_whatever_the_filter_did(shape):
    rng = np.random.default_rng(11)
    raw = rng.exponential(1.0, (*shape, 3))
    filtered = np.full_like(raw, 3.0) * np.linspace(0.5, 2.0, shape[1])[None, :, None]
    made = keep_means(filtered, raw)
    assert largest_shift(made, raw) < 1e-4
    # Within blocks it is still the filtered picture: what it was multiplied by changes slowly.
    factor = made[..., 1] / filtered[..., 1]
    assert np.abs(np.diff(np.log(factor), axis=0)).max(initial=0.0) < 0.05


def test_means_are_kept_where_fireflies_in_the_dark_were_taken_out():
    rng = np.random.default_rng(0)
    spark = rng.exponential(50.0, (200, 330, 1)) * (rng.random((200, 330, 1)) < 0.002)
    raw = np.where(np.arange(330)[None, :, None] > 200, 5.0, 0.001) + spark * np.ones(3)
    filtered = np.where(np.arange(330)[None, :, None] > 200, 5.0, 0.001) * np.ones_like(raw)
    assert largest_shift(keep_means(filtered, raw), raw) < 1e-4


def test_what_is_black_stays_black():
    black = np.zeros((2 * BLOCK, BLOCK, 3))
    raw = black.copy()
    raw[:BLOCK] = 1.0
    filtered = raw.copy()
    assert keep_means(filtered, raw)[BLOCK:].max() == 0.0
    np.testing.assert_array_equal(keep_means(black, raw), black)
