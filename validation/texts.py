"""What each case tests, in words, and where its reference values come from."""

from dataclasses import dataclass


@dataclass(frozen=True)
class CaseText:
    """Words on a case.

    Parameters
    ----------
    about : str    What is set up and what is tested.
    basis : str    How the reference values were computed.
    clause : str    Section of CIE 171:2006 with the same subject; empty: none.
    """

    about: str
    basis: str
    clause: str = ""


TEXTS = {
    "C01": CaseText(
        "A point source hangs 3 m above ten sensors on an empty floor, once isotropic and once with a cosine "
        "distribution, both of 1000 cd. Inverse-square and cosine law are tested over six decades of distance, with "
        "tilted sensors, mean spherical, cylindrical and semicylindrical illuminance, the flux of four "
        "distributions, and the whole scene turned and moved by more than 200 km.",
        "Closed forms; the spatial illuminances also by numerical averages.",
        "5.2",
    ),
    "C02": CaseText(
        "A goniometric point source without any symmetry, read from an LM-63 file, stands 3 m above 25 sensors, first "
        "level and then tilted by 30° and turned by 40°. It shows whether the file is read right, "
        "interpolated right, and whether C planes and rotations have the right sense.",
        "Closed form on the tabulated intensities, bilinear between them; the flux by exact integration of that.",
        "5.2",
    ),
    "C03": CaseText(
        "One distribution is written with quadrant, with bilateral and without symmetry, others are bilateral about the "
        "C90-C270 plane, axial, and shining up and down. Files that mean the same must give the same illuminances on "
        "the floor and, for the last, on the ceiling.",
        "Closed form on the tabulated intensities; folding by symmetry carried out a second time explicitly.",
        "5.2",
    ),
    "C04": CaseText(
        "A floodlight measured in type B and in type A coordinates stands 8 m high and looks down by 30°. Illuminances "
        "on the ground, the goniometer's angles and the flux show whether the two coordinate systems are told apart. "
        "An informative group gives what another widespread reading of type B would yield.",
        "Closed form on the tabulated intensities; the flux by quadrature over each cell of the table.",
        "5.2",
    ),
    "C05": CaseText(
        "Evenly glowing rectangles, a triangle, a disk and a sphere of 1000 cd/m2 light sensors from a thousandth of "
        "their size up to a hundred times of it, parallel, at right angles and partly below the sensor's own horizon. "
        "The same scene a thousand times smaller and larger must give the same illuminances.",
        "Lambert's contour formula and closed configuration factors, each confirmed by graded quadrature.",
        "5.3",
    ),
    "C06": CaseText(
        "A source of 10 000 lm stands off centre in a black room of 4 m x 4 m x 3 m, and in a second part sky light of "
        "four sky types enters through a roof opening of 1 m x 1 m or over the whole roof. What the surfaces receive "
        "must add up to what was emitted or came in.",
        "Closed solid angles and form factors; for the skies an overlap integral over all directions.",
        "5.4",
    ),
    "C07": CaseText(
        "Clear panes of refractive index 1.52, without absorption and with a transmittance of 0.88 at normal incidence, "
        "are tested for transmittance and reflectance from 0° to 89°, for diffuse light, for a beam through a pane and "
        "for neutrality of colour. The pane of 0.88 is the one in the openings of C13 and C15.",
        "Fresnel's equations with the two polarisations carried through the pane apart, confirmed by the explicit sum "
        "of internal reflections; one group follows the approximation of the printed table.",
        "5.5",
    ),
    "C08": CaseText(
        "A matt horizontal square of 0.5 m, 4 m and 500 m is lit evenly and sends its light to sensors where the walls "
        "and the ceiling of a room would be. In a second part a small sunlit patch of wall, of reflectance 0.5, lights "
        "a black room.",
        "Lambert's contour formula, confirmed by graded quadrature.",
        "5.6",
    ),
    "C09": CaseText(
        "A matt, evenly lit wall of 4 m x 3 m reflects light over a black box, 1 m high, that hides part of it from "
        "eleven sensors on the opposite wall and on the floor. Two floor sensors behind the box must stay dark.",
        "Lambert's contour formula on the visible rectangle, confirmed by quadrature with tests of visibility.",
        "5.7",
    ),
    "C10": CaseText(
        "Light of 10 000 lm is reflected again and again in closed rooms: a cube of 4 m at reflectances from 0 to 0.95, "
        "its mean and its course along a face, spheres of 2 m radius with the source in and off the centre, a sphere "
        "with a black port, and one sphere inside another.",
        "Closed forms for means and spheres; for points of the cube the radiosity equation, solved with exact "
        "point-to-cell factors and extrapolated.",
        "5.8",
    ),
    "C11": CaseText(
        "The fifteen standard general skies of the CIE and the traditional overcast sky are tested for relative "
        "luminance in seven directions, for the ratio of horizontal illuminance to zenith luminance with the sun at "
        "60° and at 20°, and for the illuminance of vertical planes. An even dome of 1000 cd/m2 closes the case.",
        "The formula of the standard (ISO 15469:2004, CIE S 011); integrals by two independent quadratures.",
        "5.9",
    ),
    "C12": CaseText(
        "Sky light falls through an unglazed opening of 1 m x 1 m, or through the whole open roof, into a black room "
        "of 4 m x 4 m x 3 m. Six sensors on the wall that faces the sun, eight on the floor, under all sixteen skies "
        "with the sun at 60°.",
        "Graded quadrature over the opening, confirmed by integration over directions.",
        "5.9",
    ),
    "C13": CaseText(
        "As C12 with a clear pane of transmittance 0.88 in the opening, for all sixteen skies, and with a pane "
        "without absorption for three of them. Light at grazing incidence on the pane decides the values near the roof.",
        "Graded quadrature over the opening with the pane's transmittance, confirmed by integration over directions.",
        "5.10",
    ),
    "C14": CaseText(
        "Sky and ground light enter the room through an unglazed opening in one wall, 2 m x 1 m or the whole wall. "
        "Wall, floor and ceiling sensors separate what comes from above the horizon and from below, where the ground "
        "reflects 30 %, under all sixteen skies.",
        "Graded quadrature over the opening, split at the horizon, confirmed by integration over directions and, for "
        "the ceiling, by Lambert's contour formula.",
        "5.11",
    ),
    "C15": CaseText(
        "As C14 with a clear pane of transmittance 0.88 in the opening. Floor sensors close to the window receive "
        "their light at grazing incidence on the pane.",
        "As C14, with the pane's transmittance.",
        "5.12",
    ),
    "C16": CaseText(
        "A very long opaque plate, 0.5 m, 1 m or 2 m deep at roof height, overhangs the 2 m x 1 m opening of C14. "
        "Floor sensors see the sky under it, for all sixteen skies; the part of the opening that the plate fills is "
        "tested with a glowing underside.",
        "Graded quadrature over the visible part; the plate's factor also by Lambert's contour formula.",
        "5.13",
    ),
    "C17": CaseText(
        "A very long opaque wall, 3 m, 6 m or 9 m high and 6 m away, stands before the 2 m x 1 m opening of C14. Floor "
        "sensors see the sky above a black wall under all sixteen skies, a glowing wall, and in full simulation a wall "
        "and ground of reflectance 0.3 that light each other under an even sky.",
        "Graded quadrature over the visible part; the last part by two-dimensional radiosity, solved by Nyström's "
        "method.",
        "5.14",
    ),
    "C18": CaseText(
        "Ideal mirrors reflect a point source and a glowing square, two of them at right angles and two face to face. "
        "Illuminances with images clipped by the mirror's edge are tested, and the reflectance of an interface of "
        "index 1.5.",
        "Image sources in closed form; clipped images by Lambert's contour formula; Fresnel's equations.",
        "6",
    ),
    "C19": CaseText(
        "Every surface of a closed room glows with 100 cd/m2 and reflects light with the same reflectance, up to 0.99: "
        "luminance and illuminance are then the same at all places. The number of reflections this takes is counted, "
        "and a matt sphere in even surroundings must take on its reflectance times their luminance.",
        "Closed forms that hold at every point.",
    ),
    "C20": CaseText(
        "An endless street, 10 m wide between walls 10 m high, lies under an even sky. Floor and wall illuminances are "
        "tested with black surfaces, and with walls of reflectance 0.6 and a floor of 0.3.",
        "Closed form; with reflection two-dimensional radiosity, solved by Nyström's method.",
    ),
    "C21": CaseText(
        "Light grazes a horizontal sensor: from a point source up to 89.994° from the normal, from a parallel "
        "beam, and from a square emitter 5 cm above the floor at several distances.",
        "Closed forms; the square by Lambert's contour formula and by quadrature.",
    ),
    "C22": CaseText(
        "Square emitters with sides from 0.1 mm upwards are seen from as close as their side and from as far as "
        "10 km, and a point source of 1e9 cd from 10 km and farther. Sizes and distances differ by a factor of 1e8.",
        "Closed form of the configuration factor, confirmed by quadrature.",
    ),
    "C23": CaseText(
        "An emitter of 10 mm x 10 mm with 1e9 cd/m2 hangs over a black strip that shades one of two sensors. The shaded "
        "sensor must stay dark, and with a dome of 1e-5 cd/m2 added it must show that dome alone.",
        "Closed forms.",
    ),
    "C24": CaseText(
        "A one-sided emitter lies in the plane of the sensors or faces away from them, and these must receive nothing. "
        "Vertical sensors a little above its plane receive little, and exactly that is tested.",
        "By definition; above the plane by Lambert's contour formula and quadrature.",
    ),
    "C25": CaseText(
        "A sun disk 0.533° wide lights the ground at several elevations, draws a half shadow behind an edge 10 m above "
        "it, and throws the patch of a window of 2 m x 1 m on the floor, whose corners and illuminance are tested.",
        "Closed forms; the half shadow also by integration over the cone.",
        "6",
    ),
    "C26": CaseText(
        "Even sky light of 10 000 cd/m2 enters a room of 4 m x 4 m x 3 m through a roof opening of 50 mm x 50 mm. "
        "Sensors in the black room, the flux that enters, and the mean illuminance of all surfaces at reflectances 0, "
        "0.5 and 0.8 are tested.",
        "Lambert's contour formula, confirmed by quadrature; flux balance for the means.",
    ),
    "C27": CaseText(
        "A strip 10 m long and 1 mm wide glows with 100 000 cd/m2. Sensors stand from 1 cm to 10 m away, beside it, "
        "beyond its end, and face it or look up.",
        "Lambert's contour formula, confirmed by quadrature; a line integral as a second description.",
    ),
    "C28": CaseText(
        "One thousand point sources of 100 to 400 cd hang in an uneven field of 40 m x 25 m. The sum over all of them "
        "must be complete at five sensors, under the field and beside it.",
        "Closed form, summed over all sources.",
    ),
    "C29": CaseText(
        "A closed, opaque, black box whose faces are single planes that share their edges stands under a bright dome "
        "and a sun of 100 000 lx. Inside, close to edges and in the middle, it must be dark.",
        "By definition.",
        "6",
    ),
    "C30": CaseText(
        "A black half-plane halfway between a square emitter of 1 m x 1 m and the floor hides part of it. Eleven "
        "sensors go through the shadow's edge, from full darkness to the whole emitter.",
        "Lambert's contour formula on the visible part, confirmed by quadrature.",
    ),
    "C31": CaseText(
        "A diffusing panel of 2 m x 2 m that lets 40 % through hangs 2 m above black ground under an even sky. Sensors "
        "on the ground and close below the panel receive sky light beside it and scattered light through it.",
        "Closed form.",
    ),
    "C32": CaseText(
        "Single spectral lines from 405 nm to 700 nm and low-pressure sodium light of 100 W are tested for luminous "
        "efficacy, flux, illuminance and chromaticity. A line must be neither missed nor smeared.",
        "Table of the standard observer at 1 nm, linear between.",
        "6",
    ),
    "C33": CaseText(
        "Four spectral lines of 1 W each fill a cube of 4 m whose walls reflect 5 % to 90 % of them, line by line. Mean "
        "irradiance of each line, illuminance and colour show whether light is reflected wavelength by wavelength.",
        "Closed form for each wavelength.",
        "6",
    ),
    "C34": CaseText(
        "Two paints that look alike under illuminant A differ under the fluorescent lamp FL2. Tristimulus values, "
        "CIELAB colours and their difference, and the luminance of a patch under 1000 lx are tested; an informative "
        "group tells how far three colour channels would be off.",
        "Direct summation over the spectra from 380 nm to 780 nm.",
        "6",
    ),
    "C35": CaseText(
        "A closed cube painted with the first paint of C34 is lit by illuminant A and by FL2. The colour of the light "
        "on its surfaces and the gain by reflection are tested.",
        "Closed form for each wavelength, summed over the spectra.",
        "6",
    ),
    "C36": CaseText(
        "One panel of 0.6 m x 0.6 m with 5000 cd/m2 straight ahead, one off the axis, and four of them are seen against "
        "a background of 30 cd/m2. The unified glare rating, the panels' solid angles and their position indices are "
        "tested.",
        "Closed form of the rating (CIE 117:1995) with Guth's position index.",
    ),
    "C37": CaseText(
        "Pictures of 16 and 256 rows of pixels are the surroundings, with 1000 cd/m2 in a cap of 22.5° around the zenith, "
        "the same turned by 60°, or in a band of 22.5° above and below the horizon. Planes of several slopes show whether "
        "pixels are cells of the right size at the right place, even or with a linear ramp between their middles.",
        "Closed forms, confirmed by sums over 32 million directions.",
    ),
    "C38": CaseText(
        "A sun of 10 000 lx shines through two parallel panes of transmittance 0.88, and through three, at 35°, 65° and "
        "82° to their normal, as a point and as a disk of 0.53°. What arrives behind them has also gone to and fro "
        "between them.",
        "Sums over the layers for each polarisation by itself: between two panes light keeps its polarisation.",
    ),
    "C39": CaseText(
        "A point source stands 1 m before a pane of transmittance 0.88, and between two. Sensors on both sides see it "
        "through the glass and, turned away from it, by its images in the panes.",
        "Image sources in closed form, with the reflectances and transmittances of each polarisation multiplied apart.",
    ),
    "C40": CaseText(
        "A lamp of 1000 lm is in the middle of a ball of clear glass, 3 cm in radius and of index 1.5: a point, spheres of "
        "1 mm and 1 cm, and a black glowing mesh of 5 mm. Lux maps of a closed cube, sensors and pictures of a closed "
        "sphere of reflectance 0.5 must hold all of its light, less what the black mesh takes back.",
        "Conservation of flux; in the sphere reflected light is the same everywhere. What the mesh takes back is Fresnel's "
        "reflectance, averaged over its rays.",
    ),
    "C41": CaseText(
        "A sun of 100 000 lx shines through a square hole of 5 mm or 30 mm into a closed box of 1 m and reflectance 0.5. "
        "The lux maps of all its surfaces together must hold what comes in, as often as it is reflected.",
        "Conservation of flux; what leaves by the hole again is taken for the mean, and is less than a thousandth.",
    ),
    "C42": CaseText(
        "A lamp of 1000 lm, as a point or as a sphere of 0.05 mm, is 0.1 mm from a wall of a closed room of 3 m: half of "
        "its light falls on less than a square millimetre. A spot with a beam of 0.1° lights a spot as small on the floor.",
        "Conservation of flux.",
    ),
    "C43": CaseText(
        "A lamp of 1000 lm in a closed room of 3 m whose surfaces reflect 95 % or 99 %: light is reflected a hundred times "
        "before it is absorbed.",
        "Conservation of flux.",
    ),
    "C44": CaseText(
        "Half of a closed room of 3 m with a lamp of 500 lm ends at a perfect mirror. Its lux map must be that of half of "
        "the whole room with two lamps, although most light on the far side is seen only by the mirror.",
        "Conservation of flux, the mirror's image being the other half.",
    ),
    "C45": CaseText(
        "A ball of 32 by 16 facets is shaded smoothly. An even world and a sun must give to its lux map what the facets "
        "take in, not what the normals of a true ball would make of it.",
        "Area of the outline for the sun; a convex body under an even world receives the same everywhere.",
    ),
    "C46": CaseText(
        "Skies between the standard clear and the traditional overcast one, with the sun at 60°, on six open sensors and "
        "on twelve behind the 2 m x 1 m opening of C14, over a ground that reflects 30 %.",
        "Quadrature over the hemisphere and over the opening, of the formulas by code of its own.",
    ),
    "C47": CaseText(
        "The all-weather sky of Perez, one of each of its eight classes, on six open sensors and on twelve behind the "
        "2 m x 1 m opening of C14, over a ground that reflects 30 %.",
        "Quadrature over the hemisphere and over the opening, of the model's formula and table by code of its own.",
    ),
    "C48": CaseText(
        "Skies as they are measured: luminances of Tregenza's 145 patches, one of them as bright as the surroundings of a "
        "sun, and a table every 10° of elevation and 15° of azimuth. Illuminances follow from these luminances, in lx.",
        "Quadrature over the hemisphere and over the opening of what is even in patches, and linear between places of the "
        "table.",
    ),
}
"""By case id."""
