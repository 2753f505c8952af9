#!/usr/bin/env python3
"""The table of examples/ros2/README.md: has every name of Autoware's ndt_scan_matcher, and what it calls the same
is in the sources, with that type.

usage: ros2_interface_test.py PACKAGE
"""
import pathlib
import re
import sys

# Names of the README of autoware_ndt_scan_matcher 1.9.0, of its parameter file and of its sources, by kind.
POSE = "geometry_msgs::msg::PoseWithCovarianceStamped"
CLOUD = "sensor_msgs::msg::PointCloud2"
FLOAT = "autoware_internal_debug_msgs::msg::Float32Stamped"
INPUTS = {"ekf_pose_with_covariance": POSE, "points_raw": CLOUD, "sensing/gnss/pose_with_covariance": POSE}
OUTPUTS = {
    "ndt_pose": "geometry_msgs::msg::PoseStamped", "ndt_pose_with_covariance": POSE,
    "/diagnostics": "diagnostic_msgs::msg::DiagnosticArray", "points_aligned": CLOUD, "points_aligned_no_ground": CLOUD,
    "initial_pose_with_covariance": POSE, "multi_ndt_pose": "geometry_msgs::msg::PoseArray",
    "multi_initial_pose": "geometry_msgs::msg::PoseArray", "exe_time_ms": FLOAT, "transform_probability": FLOAT,
    "nearest_voxel_transformation_likelihood": FLOAT, "no_ground_transform_probability": FLOAT,
    "no_ground_nearest_voxel_transformation_likelihood": FLOAT,
    "iteration_num": "autoware_internal_debug_msgs::msg::Int32Stamped",
    "initial_to_result_relative_pose": "geometry_msgs::msg::PoseStamped", "initial_to_result_distance": FLOAT,
    "initial_to_result_distance_old": FLOAT, "initial_to_result_distance_new": FLOAT,
    "ndt_marker": "visualization_msgs::msg::MarkerArray",
    "monte_carlo_initial_pose_marker": "visualization_msgs::msg::MarkerArray", "voxel_score_points": CLOUD,
    "debug/loaded_pointcloud_map": CLOUD}
SERVICES = {"ndt_align_srv": "autoware_internal_localization_msgs::srv::PoseWithCovarianceStamped",
            "trigger_node_srv": "std_srvs::srv::SetBool",
            "client_map_loader": "autoware_map_msgs::srv::GetDifferentialPointCloudMap"}
PARAMETERS = """
    frame.base_frame frame.ndt_base_frame frame.map_frame sensor_points.timeout_sec sensor_points.required_distance
    ndt.trans_epsilon ndt.step_size ndt.resolution ndt.max_iterations ndt.num_threads ndt.regularization.enable
    ndt.regularization.scale_factor initial_pose_estimation.particles_num initial_pose_estimation.n_startup_trials
    validation.initial_pose_timeout_sec validation.initial_pose_distance_tolerance_m
    validation.initial_to_result_distance_tolerance_m validation.critical_upper_bound_exe_time_ms
    validation.skipping_publish_num score_estimation.converged_param_type
    score_estimation.converged_param_transform_probability
    score_estimation.converged_param_nearest_voxel_transformation_likelihood score_estimation.no_ground_points.enable
    score_estimation.no_ground_points.z_margin_for_ground_removal covariance.output_pose_covariance
    covariance.covariance_estimation.covariance_estimation_type
    covariance.covariance_estimation.initial_pose_offset_model_x
    covariance.covariance_estimation.initial_pose_offset_model_y covariance.covariance_estimation.temperature
    covariance.covariance_estimation.scale_factor dynamic_map_loading.update_distance dynamic_map_loading.map_radius
    dynamic_map_loading.lidar_radius dynamic_map_loading.publish_loaded_map""".split()
MAP_UPDATE = """is_need_rebuild maps_size_before is_succeed_call_pcd_loader maps_to_add_size maps_to_remove_size
    map_update_execution_time maps_size_after is_updated_map"""
STATUSES = {
    "scan_matching_status": """topic_time_stamp sensor_points_size sensor_points_delay_time_sec
        is_succeed_transform_sensor_points sensor_points_max_distance is_activated is_succeed_interpolate_initial_pose
        is_set_map_points iteration_num local_optimal_solution_oscillation_num transform_probability
        transform_probability_diff transform_probability_before nearest_voxel_transformation_likelihood
        nearest_voxel_transformation_likelihood_diff nearest_voxel_transformation_likelihood_before
        distance_initial_to_result execution_time skipping_publish_num""",
    "initial_pose_subscriber_status": "topic_time_stamp is_activated is_expected_frame_id",
    "regularization_pose_subscriber_status": "topic_time_stamp",
    "trigger_node_service_status": "service_call_time_stamp is_activated is_succeed_service",
    "ndt_align_service_status": "service_call_time_stamp is_succeed_transform_initial_pose " + MAP_UPDATE +
                                " is_set_map_points is_set_sensor_points best_particle_score is_succeed_service",
    "map_update_status": "timer_callback_time_stamp is_activated is_set_last_update_position "
                         "distance_last_update_position_to_current_position " + MAP_UPDATE}


def rows_of(readme):
    """Per section of the table: name, type, what it is here."""
    sections, section = {}, None
    for line in readme.splitlines():
        cells = [cell.strip() for cell in line.strip().strip("|").split("|")]
        if len(cells) != 3:
            continue
        if cells[0].startswith("**"):
            section = cells[0].strip("*")
            sections[section] = {"": cells[2]}
        elif section and re.fullmatch(r"`[^`]+`", cells[0]):
            sections[section][cells[0].strip("`")] = (cells[1], cells[2])
        elif not line.startswith("|"):
            section = None
    return sections


def aliases_of(text):
    """Short names of types in the sources, as `using` gives them."""
    short = {name.rsplit("::", 1)[1]: name for name in re.findall(r"using ((?:\w+::)+\w+);", text)}
    short.update({name: full for name, full in re.findall(r"using (\w+) =\s+((?:\w+::)+\w+);", text)})
    return short


def made(text, call):
    """Names and full types of publishers, subscriptions or services."""
    aliases = aliases_of(text)
    found = re.findall(call + r'<([\w:]+)>\(\s*"([^"]+)"', text)
    return {name: aliases.get(kind, kind) for kind, name in found}


def check(faults, condition, text):
    if not condition:
        faults.append(text)


def check_messages(faults, rows, names, sources):
    for name, kind in names.items():
        check(faults, name in rows, f"{name}: no row")
        written, here = rows.get(name, ("", ""))
        check(faults, written == kind, f"{name}: the table has {written}, Autoware {kind}")
        if here.startswith("same"):
            check(faults, sources.get(name) == kind, f"{name}: the node has {sources.get(name)}, Autoware {kind}")
        else:
            check(faults, here.startswith("no: ") and len(here) > 10, f"{name}: no reason")
            check(faults, name not in sources, f"{name}: the node has it")


def check_keys(faults, section, rows, names, sources):
    for name in names:
        check(faults, name in rows, f"{section}: {name}: no row")
        here = rows.get(name, ("", ""))[1]
        if here.startswith("same"):
            check(faults, name in sources, f"{section}: {name}: not in the sources")
        else:
            check(faults, here.startswith("no: "), f"{section}: {name}: no reason")
            check(faults, name not in sources, f"{section}: {name}: in the sources")


def bodies_of(core):
    """Keys that are added in each function, with those of functions that it calls."""
    bodies = {name: body for name, body in
              re.findall(r"\n\S[^\n;]* ScanMatcher::(\w+)\([^{]*\{\n(.*?)\n\}\n", core, re.DOTALL)}
    statuses = {"scan_matching_status": ["take", "check_points", "find_start", "match", "score_start", "is_good_score",
                                         "report_match", "report_protection"],
                "initial_pose_subscriber_status": ["add_initial_pose"], "trigger_node_service_status": ["trigger"],
                "ndt_align_service_status": ["align"], "map_update_status": ["map_status"],
                "regularization_pose_subscriber_status": []}
    keys = {}
    for status, functions in statuses.items():
        text = "".join(bodies[name] for name in functions)
        keys[status] = set(re.findall(r'report\.add\(\s*"(\w+)"', text))
        check_name = not functions or f'"{status}"' in text
        assert check_name, f"{status} is not named in {functions}"
    return keys


def main():
    package = pathlib.Path(sys.argv[1])
    node = "".join((package / "src" / name).read_text() for name in ("localizer_node.h", "localizer_node.cpp"))
    core = "".join((package / "core" / name).read_text() for name in ("scan_matcher.cpp", "scan_matcher_services.cpp"))
    sections = rows_of((package / "README.md").read_text())
    faults = []
    check_messages(faults, sections["input"], INPUTS, made(node, "create_subscription"))
    check_messages(faults, sections["output"], OUTPUTS, made(node, "create_publisher"))
    check_messages(faults, sections["service"], SERVICES, made(node, "create_service"))
    declared = set(re.findall(r'declare_parameter<[^(]+>\(\s*"([\w.]+)"', node))
    check_keys(faults, "parameter", sections["parameter"], PARAMETERS, declared)
    keys = bodies_of(core)
    for status, names in STATUSES.items():
        check_keys(faults, status, sections[status], names.split(), keys[status])
        check(faults, sections[status][""].startswith("same" if keys[status] else "no: "), f"{status}: says otherwise")
    further = set().union(*keys.values()) - {name for names in STATUSES.values() for name in names.split()}
    readme = (package / "README.md").read_text()
    for name in sorted(further):
        check(faults, f"`{name}`" in readme, f"{name}: a key that README.md does not name")
    for fault in faults:
        print(fault)
    print(f"{len(INPUTS) + len(OUTPUTS) + len(SERVICES)} messages and services, {len(PARAMETERS)} parameters, "
          f"{sum(len(names.split()) for names in STATUSES.values())} keys of diagnostics")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
