"""Settings of pictures, reached as ``scene.lumenray.render``, and of the rendered view, as ``scene.lumenray.viewport``."""

from bpy.props import BoolProperty, EnumProperty, FloatProperty, IntProperty
from bpy.types import PropertyGroup

from ..foundation.settings import percentage, redraw_views

METHODS = [
    ("AUTO", "Automatic", "What suits the scene and the picture, which says which and why", 0),
    ("CELLS", "Cells", "Radiance kept on coarse cells: fast; its bias is measured", 1),
    ("PATHS", "Full Paths", "Paths to their end: no bias at all, slower in rooms", 2),
]
"""How pictures find the radiance beyond the first bounce."""


class LumenrayRenderSettings(PropertyGroup):
    """When a picture is done, and what is written of it."""

    stop: EnumProperty(
        name="Stop By",
        description="When the render is done. Default Samples: pictures of an animation are equally good",
        items=[
            ("SAMPLES", "Samples", "After a number of samples per pixel", 0),
            ("ERROR", "Error", "When the picture's relative standard error is reached", 1),
            ("TIME", "Time", "After a time", 2),
        ],
        default="SAMPLES",
    )
    samples: IntProperty(
        name="Samples",
        description=(
            "Number of samples per pixel on the mean, more where it is noisy; four times as many halve the noise. "
            "Default 64: enough to judge a room"
        ),
        default=64,
        min=2,
        max=1 << 20,
    )
    error: FloatProperty(
        name="Relative Error",
        description=(
            "Standard error of the pixels relative to their luminance, dark ones to the mean, as a share. Default "
            "0.02: 2 %, hardly seen"
        ),
        default=0.02,
        min=0.0001,
        max=1.0,
        precision=4,
    )
    error_percent: percentage(
        "error",
        "Error",
        "Standard error of the pixels relative to their luminance, dark ones to the mean. Default 2 %: hardly seen",
    )
    time: FloatProperty(
        name="Time",
        description="Time of rendering in seconds. Default 60: a minute, for drafts",
        default=60.0,
        min=0.1,
        max=1e7,
        subtype="TIME_ABSOLUTE",
    )
    method: EnumProperty(
        name="Method",
        description=(
            "What stands for the radiance beyond the first bounce. Default Automatic: fast where its bias is small"
        ),
        items=METHODS,
        default="AUTO",
    )
    use_unbiased: BoolProperty(
        name="Unbiased",
        description=(
            "Let the expected picture be that of full paths: Automatic follows them, and Cells correct what they change. "
            "Default off: the bias of cells is small and measured, and taking it out takes many times as long"
        ),
        default=False,
    )
    use_denoising: BoolProperty(
        name="Denoise",
        description=(
            "Let Open Image Denoise, which comes with the extension Lumenray Denoiser, guess what the Combined pass would "
            "look like without noise; all other passes stay as computed. Default off: what is seen is what was computed"
        ),
        default=False,
    )
    use_spectral_file: BoolProperty(
        name="Spectral EXR",
        description="Write a spectral OpenEXR beside the picture. Default off: few programs read it",
        default=False,
    )
    spectral_bands: IntProperty(
        name="Bands",
        description=(
            "Number of wavelength bands from 380 to 780 nm. Default 20: bands of 20 nm, which most lamps need no "
            "finer"
        ),
        default=20,
        min=2,
        max=400,
    )
    use_pass_luminance: BoolProperty(
        name="Luminance",
        description="Luminance pass in cd/m². Default on: it costs nothing and can be read off",
        default=True,
    )
    use_pass_illuminance: BoolProperty(
        name="Illuminance",
        description="Illuminance of the visible surface in lx. Default off: it costs about as much as the picture",
        default=False,
    )
    use_pass_denoising: BoolProperty(
        name="Denoising Data",
        description=(
            "Passes Denoising Albedo, Normal and Depth, which guide the node Denoise of the compositor. Default off: "
            "only that node wants them"
        ),
        default=False,
    )


class LumenrayViewportSettings(PropertyGroup):
    """What the 3D view shows in rendered shading, and for how long it computes."""

    display: EnumProperty(
        name="Viewport Shows",
        description="What the 3D view shows in rendered shading. Default Picture: as the render will be",
        items=[
            ("PICTURE", "Picture", "In colour, as in the render", 0),
            ("LUMINANCE", "Luminance", "Without colour", 1),
            ("FALSE_LUMINANCE", "False Colours [cd/m²]", "Luminance in cd/m², with a scale", 2),
            (
                "FALSE_ILLUMINANCE",
                "False Colours [lx]",
                "Illuminance of the visible surfaces in lx, with a scale; takes about twice the time",
                3,
            ),
            (
                "PHOTOGRAPHIC",
                "Tone: Photographic",
                "For looking: exposed as a photographer does, what is brighter rolled off (Reinhard 2002)",
                4,
            ),
            (
                "VISUAL",
                "Tone: As Eyes See",
                "For looking: contrasts of adapted eyes, with their veil of glare, and without colour at night (Ward Larson "
                "1997)",
                5,
            ),
        ],
        default="PICTURE",
        update=redraw_views,
    )
    samples: IntProperty(
        name="Viewport Samples",
        description=(
            "Number of paths per pixel after which the view in rendered shading rests. Default 256: little noise is "
            "left in a room"
        ),
        default=256,
        min=2,
        max=1 << 20,
        update=redraw_views,
    )
    method: EnumProperty(
        name="Viewport Method",
        description=(
            "What stands for the radiance beyond the first bounce, once the view has been left alone for some seconds; the "
            "first images come by paths. Default Automatic: a room gets clean sooner"
        ),
        items=METHODS,
        default="AUTO",
        update=redraw_views,
    )
    use_denoising: BoolProperty(
        name="Denoise at Rest",
        description=(
            "Show a copy of the picture that Open Image Denoise has made, where it is installed, once the view has been "
            "still for a second; false colours are never denoised. Default on: a room looks as it will be, and the "
            "view says so"
        ),
        default=True,
        update=redraw_views,
    )
    automatic: BoolProperty(
        name="Automatic Scale",
        description="Set the top of the scale from the view itself. Default on: nothing lies beyond the scale",
        default=True,
        update=redraw_views,
    )
    low: FloatProperty(
        name="From",
        description="Lower end of the scale of false colours, in its unit. Default 0: the scale begins with darkness",
        default=0.0,
        min=0.0,
        max=1e9,
        update=redraw_views,
    )
    high: FloatProperty(
        name="To",
        description=(
            "Upper end of the scale of false colours, in its unit. Default 1000: twice the 500 lx of EN 12464-1 for "
            "offices"
        ),
        default=1000.0,
        min=1e-6,
        max=1e9,
        update=redraw_views,
    )
    logarithmic: BoolProperty(
        name="Logarithmic",
        description=(
            "Equal ratios take equal lengths of the scale. Default off: twice the light is twice as far along"
        ),
        default=False,
        update=redraw_views,
    )
    isolux_lines: BoolProperty(
        name="Isolux Lines",
        description=(
            "Lines of equal illuminance or luminance with their values, of means over as many pixels as the noise asks for. "
            "Default off: colours tell the distribution"
        ),
        default=False,
        update=redraw_views,
    )
    use_values: BoolProperty(
        name="Values",
        description=(
            "Values at points in even distances, of the same means as isolux lines. Default off: they cover what is seen"
        ),
        default=False,
        update=redraw_views,
    )


CLASSES = (LumenrayRenderSettings, LumenrayViewportSettings)
