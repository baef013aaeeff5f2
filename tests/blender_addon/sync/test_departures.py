"""Nothing of Blender is silent: every setting is taken over, told where it differs, or changes no picture of Cycles.

The lists are those of Blender itself, so that a setting that a new version brings fails here until somebody has judged it.
"""

import bpy
import pytest
from conversion import converted_scene

from lumenray.blender_addon.sync import departures

pytestmark = pytest.mark.blender


def words(text):
    return set(text.split())


def told(table):
    """Names of settings of a table, by the owner's own property or that of Cycles."""
    own = {each.path.split(".")[0] for each in table} - {"cycles", "dof", "render"}
    of = {
        part: {each.path.split(".")[1] for each in table if each.path.startswith(f"{part}.")}
        for part in ("cycles", "dof", "render")
    }
    return own, of


def names_of(struct, base=bpy.types.ID):
    """Names of the properties that a struct has beyond its base."""
    common = set() if base is None else {each.identifier for each in base.bl_rna.properties}
    return {each.identifier for each in struct.bl_rna.properties} - common - {"rna_type", "name"}


EEVEE_LIGHT = words(
    "specular_factor diffuse_factor transmission_factor volume_factor use_custom_distance cutoff_distance "
    "shadow_buffer_clip_start shadow_filter_radius shadow_maximum_resolution use_shadow_jitter shadow_jitter_overblur "
    "use_absolute_resolution use_square shadow_cascade_max_distance shadow_cascade_count shadow_cascade_exponent "
    "shadow_cascade_fade show_cone"
)
LIGHT = words(
    "type use_temperature color temperature temperature_color use_shadow exposure normalize node_tree use_nodes energy "
    "shadow_soft_size angle spot_blend spot_size shape size size_y spread animation_data cycles"
)

STRUCTS = {
    "camera": (
        bpy.types.Camera,
        departures.CAMERA,
        # Taken over; kinds of panoramas that are not known are told by `convert_camera`.
        words(
            "type sensor_fit angle_x angle_y angle clip_start clip_end lens sensor_width sensor_height ortho_scale "
            "shift_x shift_y lens_unit panorama_type latitude_min latitude_max longitude_min longitude_max dof "
            "fisheye_fov fisheye_lens fisheye_polynomial_k0 fisheye_polynomial_k1 fisheye_polynomial_k2 "
            "fisheye_polynomial_k3 fisheye_polynomial_k4 central_cylindrical_range_u_min "
            "central_cylindrical_range_u_max central_cylindrical_range_v_min central_cylindrical_range_v_max "
            "central_cylindrical_radius animation_data"
        ),
        # Drawn in the window alone, or of cameras and views that are told as a whole.
        words(
            "passepartout_alpha display_size stereo show_limits show_mist show_passepartout show_safe_areas "
            "show_safe_center show_name show_sensor show_background_images composition_guide_color "
            "show_composition_center show_composition_center_diagonal show_composition_thirds show_composition_golden "
            "show_composition_golden_tria_a show_composition_golden_tria_b show_composition_harmony_tri_a "
            "show_composition_harmony_tri_b background_images custom_filepath custom_shader custom_mode "
            "custom_bytecode custom_bytecode_hash cycles_custom lumenray"
        ),
    ),
    "world": (
        bpy.types.World,
        departures.WORLD,
        words(
            "color node_tree use_nodes lightgroup cycles cycles_visibility animation_data lumenray"
        ),
        # Of EEVEE, of passes, and of the approximation of light in corners.
        words(
            "use_eevee_finite_volume light_settings mist_settings probe_resolution sun_threshold sun_angle "
            "use_sun_shadow sun_shadow_maximum_resolution sun_shadow_filter_radius use_sun_shadow_jitter "
            "sun_shadow_jitter_overblur"
        ),
    ),
    "material": (
        bpy.types.Material,
        departures.MATERIAL,
        # How a mesh is displaced is read with the node at the output's socket.
        words(
            "displacement_method pass_index node_tree use_nodes diffuse_color animation_data cycles lumenray"
        ),
        words(
            "surface_render_method blend_method alpha_threshold use_transparency_overlap show_transparent_back "
            "use_backface_culling use_backface_culling_shadow use_backface_culling_lightprobe_volume "
            "use_raytrace_refraction use_screen_refraction use_sss_translucency refraction_depth thickness_mode "
            "use_thickness_from_shadow volume_intersection_method max_vertex_displacement preview_render_type "
            "use_preview_world texture_paint_images texture_paint_slots paint_active_slot paint_clone_slot "
            "specular_color roughness specular_intensity metallic line_color line_priority grease_pencil "
            "is_grease_pencil lineart"
        ),
    ),
    "view layer": (
        bpy.types.ViewLayer,
        (),
        # Passes that are not made are in `UNMADE_PASSES`; hair and volumes are told wherever they are.
        words(
            "material_override world_override use_solid use_sky layer_collection objects use cycles use_pass_combined "
            "use_pass_z use_pass_normal use_pass_object_index use_pass_material_index use_strand use_volumes "
            "lightgroups use_freestyle freestyle_settings use_motion_blur"
        )
        | set(departures.UNMADE_PASSES),
        words(
            "samples pass_alpha_threshold eevee aovs active_aov active_aov_index active_lightgroup "
            "active_lightgroup_index pass_cryptomatte_depth use_pass_cryptomatte_accurate use_ao use_grease_pencil "
            "active_layer_collection has_export_collections use_pass_grease_pencil depsgraph"
        ),
    ),
    "object": (
        bpy.types.Object,
        departures.OBJECT,
        words(
            "data type material_slots matrix_world modifiers constraints particle_systems hide_viewport hide_render "
            "show_instancer_for_render show_instancer_for_viewport visible_camera visible_diffuse visible_glossy "
            "visible_transmission visible_volume_scatter visible_shadow is_holdout is_shadow_catcher instance_type "
            "use_instance_vertices_rotation use_instance_faces_scale instance_faces_scale instance_collection "
            "is_instancer is_from_instancer is_from_set pass_index lightgroup light_linking animation_data cycles "
            "lumenray"
        ),
        # How it comes to stand and to look as it does is Blender's; what only nodes can ask for is told by them (colour);
        # terminators of shadows are remedies of faults that this engine's shading does not have.
        words(
            "mode bound_box parent parent_type parent_vertices parent_bone use_parent_final_indices "
            "use_camera_lock_parent track_axis up_axis active_material active_material_index location "
            "rotation_quaternion rotation_axis_angle rotation_euler rotation_mode scale dimensions delta_location "
            "delta_rotation_euler delta_rotation_quaternion delta_scale lock_location lock_rotation lock_rotation_w "
            "lock_rotations_4d lock_scale matrix_local matrix_basis matrix_parent_inverse shader_effects vertex_groups "
            "empty_display_type empty_display_size empty_image_offset image_user empty_image_depth "
            "show_empty_image_perspective show_empty_image_orthographic show_empty_image_only_axis_aligned "
            "use_empty_image_alpha empty_image_side add_rest_position_attribute color field collision soft_body "
            "rigid_body rigid_body_constraint use_simulation_cache hide_select hide_probe_volume hide_probe_sphere "
            "hide_probe_plane hide_surface_pick display_type show_bounds display_bounds_type show_name show_axis "
            "show_texture_space show_wire show_all_edges use_grease_pencil_lights show_transparent show_in_front pose "
            "show_only_shape_key use_shape_key_edit_mode active_shape_key active_shape_key_index "
            "use_dynamic_topology_sculpting display lineart use_mesh_mirror_x use_mesh_mirror_y use_mesh_mirror_z "
            "shadow_terminator_normal_offset shadow_terminator_geometry_offset shadow_terminator_shading_offset "
            "animation_visualization motion_path selection_sets active_selection_set"
        ),
    ),
}
"""By what it is: Blender's type, what is told, what is read or told elsewhere, and what changes no picture of Cycles."""

CYCLES = {
    "camera": set(),
    # What is sampled how often decides about noise.
    "light": words("use_multiple_importance_sampling is_portal is_caustics_light"),
    "world": words(
        "is_caustics_light sampling_method sample_map_resolution volume_sampling volume_interpolation volume_step_size"
    ),
    "material": words(
        "emission_sampling use_bump_map_correction volume_sampling volume_interpolation volume_step_rate"
    ),
    # Culling is told of the scene; motion is blurred as it is, not by steps.
    "object": words(
        "use_motion_blur use_deform_motion motion_steps use_camera_cull use_distance_cull shadow_terminator_offset "
        "shadow_terminator_geometry_offset ao_distance is_caustics_caster is_caustics_receiver"
    ),
    "view layer": words(
        "pass_debug_sample_count pass_render_time use_pass_volume_direct use_pass_volume_indirect "
        "use_pass_volume_scatter use_pass_volume_transmit use_pass_volume_majorant use_pass_shadow_catcher "
        "use_denoising denoising_store_passes"
    ),
    # Noise, its filters, what limits paths and what approximates light; hair, volumes and displacement are told.
    "scene": words(
        "device shading_system preview_pause use_denoising denoiser denoising_prefilter denoising_quality "
        "denoising_input_passes denoising_use_gpu use_preview_denoising preview_denoiser preview_denoising_prefilter "
        "preview_denoising_quality preview_denoising_input_passes preview_denoising_start_sample "
        "preview_denoising_use_gpu samples preview_samples use_sample_subset sample_offset sample_subset_length "
        "time_limit sampling_pattern scrambling_distance preview_scrambling_distance auto_scrambling_distance "
        "use_layer_samples light_sampling_threshold use_adaptive_sampling adaptive_threshold adaptive_min_samples "
        "use_preview_adaptive_sampling preview_adaptive_threshold preview_adaptive_min_samples "
        "direct_light_sampling_type use_light_tree min_light_bounces min_transparent_bounces caustics_reflective "
        "caustics_refractive blur_glossy use_guiding use_deterministic_guiding guiding_distribution_type "
        "guiding_directional_sampling_type use_surface_guiding surface_guiding_probability use_volume_guiding "
        "guiding_training_samples volume_guiding_probability use_guiding_direct_light use_guiding_mis_weights "
        "guiding_roughness_threshold max_bounces diffuse_bounces glossy_bounces transmission_bounces volume_bounces "
        "transparent_max_bounces volume_step_rate volume_preview_step_rate volume_max_steps volume_biased dicing_rate "
        "preview_dicing_rate max_subdivisions dicing_camera offscreen_dicing_scale film_transparent_roughness "
        "pixel_filter_type filter_width seed use_animated_seed sample_clamp_direct sample_clamp_indirect "
        "debug_bvh_type debug_use_spatial_splits debug_use_hair_bvh debug_use_compact_bvh debug_bvh_time_steps "
        "bake_type camera_cull_margin distance_cull_margin rolling_shutter_type rolling_shutter_duration texture_limit "
        "use_fast_gi fast_gi_method ao_bounces ao_bounces_render use_auto_tile tile_size debug_use_cpu_avx2 "
        "debug_use_cpu_sse42 debug_bvh_layout debug_use_cuda_adaptive_compile debug_use_optix_debug "
        "debug_use_hip_adaptive_compile debug_use_metal_adaptive_compile"
    ),
}
"""Settings of Cycles that change no picture without noise, or that are told elsewhere, by owner."""

RENDER = words(
    "image_settings resolution_x resolution_y resolution_percentage preview_pixel_size pixel_aspect_x pixel_aspect_y "
    "ppm_factor ppm_base ffmpeg fps fps_base frame_map_old frame_map_new dither_intensity filter_size film_transparent "
    "threads threads_mode motion_blur_shutter motion_blur_position motion_blur_shutter_curve hair_type hair_subdiv "
    "use_high_quality_normals use_border border_min_x border_min_y border_max_x border_max_y use_crop_to_border "
    "use_placeholder use_overwrite use_compositing use_sequencer use_file_extension file_extension is_movie_format "
    "use_lock_interface filepath use_render_cache use_stamp_time use_stamp_date use_stamp_frame use_stamp_frame_range "
    "use_stamp_camera use_stamp_lens use_stamp_scene use_stamp_note use_stamp_marker use_stamp_filename "
    "use_stamp_sequencer_strip use_stamp_render_time stamp_note_text use_stamp use_stamp_labels metadata_input "
    "use_stamp_memory use_stamp_hostname stamp_font_size stamp_foreground stamp_background sequencer_gl_preview "
    "use_sequencer_override_scene_strip use_single_layer views stereo_views views_format engine has_multiple_engines "
    "use_spherical_stereo use_simplify simplify_subdivision simplify_child_particles simplify_subdivision_render "
    "simplify_child_particles_render simplify_volumes use_simplify_normals simplify_gpencil simplify_gpencil_onplay "
    "simplify_gpencil_antialiasing simplify_gpencil_view_fill simplify_gpencil_modifier simplify_gpencil_shader_fx "
    "simplify_gpencil_tint use_persistent_data line_thickness_mode line_thickness bake compositor_device "
    "compositor_precision compositor_denoise_device compositor_denoise_preview_quality "
    "compositor_denoise_final_quality"
)
"""Settings of renders that are read, that Blender itself does, or that change nothing of a frame."""


@pytest.mark.parametrize("kind", STRUCTS)
def test_every_setting_has_been_judged(kind):
    struct, table, elsewhere, without = STRUCTS[kind]
    names = names_of(struct)
    own, _ = told(table)
    assert names <= own | elsewhere | without
    assert not elsewhere & without


@pytest.mark.parametrize(
    "struct",
    [bpy.types.PointLight, bpy.types.SunLight, bpy.types.SpotLight, bpy.types.AreaLight],
    ids=lambda struct: struct.__name__,
)
def test_every_setting_of_lights_has_been_judged(struct):
    own, _ = told(departures.LIGHT)
    assert names_of(struct) <= own | LIGHT | EEVEE_LIGHT | {"lumenray"}


def test_every_setting_of_renders_and_of_depth_of_field_has_been_judged():
    _, of = told((*departures.SCENE, *departures.STILL))
    assert names_of(bpy.types.RenderSettings, None) <= of["render"] | RENDER
    _, of = told(departures.CAMERA)
    known = words(
        "use_dof focus_object focus_distance aperture_fstop aperture_rotation aperture_blades aperture_ratio"
    )
    assert names_of(bpy.types.CameraDOFSettings, None) <= of["dof"] | known


def owners():
    """What has settings of Cycles."""
    scene = bpy.context.scene
    light = bpy.data.lights.new("Lamp", "POINT")
    return {
        "scene": (scene, departures.SCENE),
        "object": (bpy.data.objects.new("Lamp", light), departures.OBJECT),
        "light": (light, departures.LIGHT),
        "world": (bpy.data.worlds.new("World"), departures.WORLD),
        "material": (bpy.data.materials.new("Paint"), departures.MATERIAL),
        "view layer": (scene.view_layers[0], ()),
    }


@pytest.fixture
def cycles():
    """Settings of Cycles, which come with its add-on."""
    bpy.ops.preferences.addon_enable(module="cycles")


@pytest.mark.parametrize("kind", ["scene", "object", "light", "world", "material", "view layer"])
def test_every_setting_of_cycles_has_been_judged(kind, cycles):
    owner, table = owners()[kind]
    _, of = told(table)
    assert names_of(type(owner.cycles), None) <= of["cycles"] | CYCLES[kind]


# ---- what is told ----


def add_object(name, data):
    made = bpy.data.objects.new(name, data)
    bpy.context.scene.collection.objects.link(made)
    return made


@pytest.fixture
def stage(cycles):
    """A floor with a paint, a lamp, a world and a camera, all as Blender makes them."""
    scene = bpy.context.scene
    mesh = bpy.data.meshes.new("Floor")
    mesh.from_pydata([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)], [], [(0, 1, 2, 3)])
    mesh.materials.append(bpy.data.materials.new("Paint"))
    add_object("Floor", mesh)
    add_object("Lamp", bpy.data.lights.new("Lamp", "POINT"))
    scene.camera = add_object("Eye", bpy.data.cameras.new("Eye"))
    scene.camera.location.z = 2.0
    scene.world = bpy.data.worlds.new("World")
    return scene


def messages():
    return [row.message for row, _ in converted_scene().report.rows]


def set_values(owner, values):
    for path, value in values.items():
        *steps, last = path.split(".")
        holder = owner
        for step in steps:
            holder = getattr(holder, step)
        setattr(holder, last, value)


SHOWN = {
    "camera": lambda: bpy.data.cameras["Eye"],
    "light": lambda: bpy.data.lights["Lamp"],
    "world": lambda: bpy.data.worlds["World"],
    "material": lambda: bpy.data.materials["Paint"],
    "scene": lambda: bpy.context.scene,
    "view layer": lambda: bpy.context.view_layer,
}


def test_what_blender_makes_departs_in_nothing(stage):
    assert messages() == []


@pytest.mark.parametrize(
    ("kind", "values", "message"),
    [
        ("camera", {"type": "CUSTOM"}, "type CUSTOM"),
        ("light", {"cycles.max_bounces": 0}, "0 times at most"),
        ("light", {"shadow_soft_size": 0.5}, "soft falloff"),
        ("light", {"use_shadow": False}, "no shadows"),
        ("world", {"cycles.max_bounces": 1}, "1 times at most"),
        ("material", {"use_transparent_shadow": False}, "transparent shadows"),
        ("material", {"cycles.use_bump_map_correction": False}, "correction of bump maps"),
        ("scene", {"render.use_motion_blur": True}, "motion blur is for renders"),
        ("scene", {"render.use_multiview": True}, "stereo"),
        ("scene", {"render.use_freestyle": True}, "Freestyle"),
        ("scene", {"cycles.film_exposure": 2.0}, "film exposure of 2"),
        (
            "scene",
            {"render.film_transparent": True, "cycles.film_transparent_glass": True},
            "glass is transparent",
        ),
        ("scene", {"render.use_simplify": True, "cycles.use_camera_cull": True}, "does not see"),
        ("scene", {"render.use_simplify": True, "cycles.use_distance_cull": True}, "far from"),
        (
            "scene",
            {"render.use_simplify": True, "cycles.texture_limit_render": "512"},
            "smaller than 512",
        ),
        ("view layer", {"use_pass_mist": True, "use_pass_diffuse_color": True}, "not made"),
    ],
)
def test_what_differs_is_told(stage, kind, values, message):
    set_values(SHOWN[kind](), values)
    (told_of,) = [each for each in messages() if message in each]
    assert told_of


@pytest.mark.parametrize(
    ("kind", "values"),
    [
        ("camera", {"dof.use_dof": True, "dof.aperture_blades": 6, "dof.aperture_ratio": 2.0}),
        ("camera", {"type": "ORTHO", "dof.use_dof": True}),
        ("camera", {"type": "PANO", "clip_end": 1.5}),
        ("scene", {"cycles.use_camera_cull": True, "cycles.film_transparent_glass": True}),
        ("view layer", {"use_pass_z": True, "use_pass_normal": True}),
    ],
)
def test_what_has_no_effect_is_not_told(stage, kind, values):
    set_values(SHOWN[kind](), values)
    assert messages() == []
