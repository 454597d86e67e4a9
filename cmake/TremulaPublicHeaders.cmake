# The headers that are installed: what a user of the library needs, and what those include. A test compiles each by itself
# against the installed tree, so none of them includes one that is not here.
set(public_headers pipeline)
set(base_headers error memory types)
set(numerics_headers lanczos pairwise_filter time_axis)
set(geometry_headers expression grow impression lsystem meadow plants quadric_mesh skeleton strands surface texels)
set(structure_headers beam beam_tree bent_tree eigen_problem equilibrium frame frame_presets heavy_rod load_margin material member panel plausibility
    plate_element prestress round_section sag sheet sheet_presets sites structure uniform_beam)
set(modes_headers mode_quality modes solve_modes)
set(wind_headers coherence field field_statistics gust_script gust_statistics iec point_wind profile spectrum stam_wind synthesis turbulent_wind
    travelling_field turbulent_wind_at_points waves)
set(dynamics_headers basis branch_oscillators canopy_sway damping drag_in_time drift flapping flutter foliage free_decay gauge gauge_reading grass_response
    gust_average gust_response lean loads motion motion_statistics oscillators principal_motion pull response response_field shelter static_correction
    transfer trunk_sway wind_forces)
set(deformation_headers bend_table bent_pose bent_space blade_skin drift_pose fit_rig grass_pose impression_motion loop morph_targets panel_pose pose principal_shapes rig sheet_pose volume)
set(render_headers camera daylight denoise image linear_image render tone_map)
set(io_headers atomic_file beam_plot contact_sheet drift_page exr film frame_file gauge_table gltf grass_page gust_plot gust_table html impression_page loop_writers mesh_compression
    modes_plot pose_table profile_table sheet_file skeleton_files spectrum_table swc table_header text_table treeqsm turbsim vdb volume_page vti wind_plot
    wind_targets wind_verdict)
set(scene_headers film_camera gust_arrows haze placing scene scene_file scene_keys)
set(raytrace_headers impression_rays ray_shape raytrace volume_shape)
foreach(folder base numerics geometry structure modes wind dynamics deformation render raytrace io scene)
  foreach(header ${${folder}_headers})
    list(APPEND public_headers ${folder}/${header})
  endforeach()
endforeach()
