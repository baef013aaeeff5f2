"""Why pictures of single files differ from Cycles', by the names of the files: facts that were looked into, one by one."""

REASONS = {
    "armory_light_area": (
        "its walls have two faces each in the same place, which shade each other in Cycles, so that they are black there; "
        "without the second faces, with one roughness and without its sky the means differ by 0.9 % and the blocks by "
        "0.9 %. That the roughness, a checkerboard, becomes its mean, the report tells"
    ),
    "armory_light_ies": (
        "its three lamps, balls of 0.25 m half a metre from a wall, have a soft falloff, which makes a disk of each that "
        "faces every point; a disk is no body, and the report tells it. With the soft falloff off the blocks differ by 7 % "
        "at few samples, in place of 62 %"
    ),
    "gltf_05_metallic_sphere_light": (
        "the node groups of its materials and lights and the picture of its surroundings lie in files that are not there; "
        "Cycles shows the missing picture in magenta, Lumenray in grey 0.5, with an error for each in the report; the "
        "command line refuses such a file at first"
    ),
    "ignis_two-planes": (
        "nearly all of the mean is a luminous ball of half a pixel, and what a picture has of it hangs on the filter of its "
        "pixels and on where in a pixel it falls: at 64 x 64 pixels it is 0.123 ± 0.005 pixels, the mean over twelve "
        "places, where Cycles has 0.124. All else differs by 1 %, and with the ball magnified 40 times the means "
        "differ by 0.1 %"
    ),
}
"""Why, by the files' names without their ending."""
