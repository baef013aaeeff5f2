"""Features that are said and left out on purpose, each with the reason: their differences do not count."""

REASONS = {
    "Add Shader": "no surface sends out more light than comes",
    "Blackbody": "the colour of light of 4000 K is none of a surface: its red is above 1",
    "Image, sRGB bytes": "light is mixed between pixels and not the numbers that encode it",
    "Image, noise in sRGB bytes": "light is mixed between pixels and not the numbers that encode it",
    "Volume, absorption": "light below surfaces is followed in solid glass alone; lux jobs refuse a scene with this",
    "Volume, scatter": "light between surfaces is not followed; lux jobs refuse a scene with this",
    "Volume, principled": "light between surfaces is not followed; lux jobs refuse a scene with this",
    "Film, exposure of Cycles": "exposure is that of a white luminance or of EV100, which the film settings state",
    "Motion blur, light": "a light that moves is blurred as all else, which a render tells; in Cycles it stands still",
    "Motion blur, rolling shutter": "a shutter that rolls over the picture is no exposure; a render tells that it does not",
    "Camera distance": "a reflectance that depends on where the camera stands is none",
    "Light, temperature": "light and paint are spectra; three numbers do not tell how much of one the other reflects",
    "Light, slide in colour": "light and paint are spectra, as above; on grey surfaces the slide agrees",
    "Light, negative": "no light takes light away, and lux less than none are no answer",
    "Light, no bounces": "light that ends at the first surface breaks the balance of energy that every lux stands on",
    "Light, no shadow": "what shades a light shades it in every lux map; a light that passes walls has none",
    "Light, diffuse off": "a surface answers a light with all of its model, by one measured reflectance",
    "Light, constant falloff": "the inverse-square law is what a luminous intensity means",
    "Light linking": "light falls on all that it reaches; a room that is lit for some objects alone has no lux",
    "Shadow linking": "what stands in the light shades it; a room that is shaded by some objects alone has no lux",
    "Point, soft falloff 0.5": "a disk that faces every point is no body; the ball has the same intensity",
    "Ambient occlusion as a factor": "it darkens by what stands near by, which light itself does already where it is traced",
    "Bevel": "it asks for the shape of edges by rays at every place; bevel the mesh",
    "World, not for diffuse rays": "a surface answers the sky with all of its model, by one measured reflectance",
    "Object, not for diffuse rays": "an object that some light meets and other does not has no balance of energy",
    "Object, not for glossy rays": "an object that some light meets and other does not has no balance of energy",
    "Object, no shadow": "light that passes an object and is reflected by it would be there twice",
    "Principled, film on paint": (
        "white paint below this film in a white furnace keeps 0.953 of green light in Cycles, 0.9995 here; 1 is due"
    ),
    "Principled, film on glass": "a film in Cycles is thinner from inside the glass, as of the Glass BSDF",
    "Glass, thin film": (
        "at 30 degrees inside the glass 0.796 of green light passes in Cycles, 0.934 by Airy's formula and on the way back: "
        "from inside Cycles divides the film's index by that of the glass and keeps the thickness"
    ),
    "Glossy, anisotropic": (
        "Cycles makes up for light between facets as if they lay along nothing: a white furnace keeps 0.6585, where 1 is due"
    ),
    "Principled, anisotropy turned": "Cycles makes up for light between facets as if they lay along nothing, as above",
    "Object, shadow catcher": "light that the floor throws on the ball counts, which Cycles leaves out",
}
"""Why, by the features' keys."""
