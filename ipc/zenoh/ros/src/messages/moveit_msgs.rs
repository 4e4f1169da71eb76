//! MoveIt's scenes, requests and answers.

use super::builtin_interfaces::Duration;
use super::geometry_msgs::{
    Accel, Pose, PoseStamped, Quaternion, TransformStamped, Twist, Vector3,
};
use super::object_recognition_msgs::ObjectType;
use super::octomap_msgs::OctomapWithPose;
use super::sensor_msgs::{JointState, MultiDOFJointState};
use super::shape_msgs::{Mesh, Plane, SolidPrimitive};
use super::std_msgs::{ColorRGBA, Header};
use super::trajectory_msgs::{JointTrajectory, MultiDOFJointTrajectory};
use crate::Byte;
use crate::message::{messages, services};

messages! {
    /// Add 0, remove 1, append 2, move 3.
    CollisionObject = "moveit_msgs/msg/CollisionObject" {
        header: Header,
        pose: Pose,
        id: String,
        r#type: ObjectType,
        primitives: Vec<SolidPrimitive>,
        primitive_poses: Vec<Pose>,
        meshes: Vec<Mesh>,
        mesh_poses: Vec<Pose>,
        planes: Vec<Plane>,
        plane_poses: Vec<Pose>,
        subframe_names: Vec<String>,
        subframe_poses: Vec<Pose>,
        operation: Byte,
    }

    /// One that a link carries.
    AttachedCollisionObject = "moveit_msgs/msg/AttachedCollisionObject" {
        link_name: String,
        object: CollisionObject,
        touch_links: Vec<String>,
        detach_posture: JointTrajectory,
        weight: f64,
    }

    /// Where all joints are, and what links carry.
    RobotState = "moveit_msgs/msg/RobotState" {
        joint_state: JointState,
        multi_dof_joint_state: MultiDOFJointState,
        attached_collision_objects: Vec<AttachedCollisionObject>,
        is_diff: bool,
    }

    /// Of joints of either kind.
    RobotTrajectory = "moveit_msgs/msg/RobotTrajectory" {
        joint_trajectory: JointTrajectory,
        multi_dof_joint_trajectory: MultiDOFJointTrajectory,
    }

    /// A row of the matrix.
    AllowedCollisionEntry = "moveit_msgs/msg/AllowedCollisionEntry" {
        enabled: Vec<bool>,
    }

    /// Who may touch whom.
    AllowedCollisionMatrix = "moveit_msgs/msg/AllowedCollisionMatrix" {
        entry_names: Vec<String>,
        entry_values: Vec<AllowedCollisionEntry>,
        default_entry_names: Vec<String>,
        default_entry_values: Vec<bool>,
    }

    /// How much thicker a link is taken (m).
    LinkPadding = "moveit_msgs/msg/LinkPadding" {
        link_name: String,
        padding: f64,
    }

    /// How much larger a link is taken.
    LinkScale = "moveit_msgs/msg/LinkScale" {
        link_name: String,
        scale: f64,
    }

    /// For pictures.
    ObjectColor = "moveit_msgs/msg/ObjectColor" {
        id: String,
        color: ColorRGBA,
    }

    /// What stands.
    PlanningSceneWorld = "moveit_msgs/msg/PlanningSceneWorld" {
        collision_objects: Vec<CollisionObject>,
        octomap: OctomapWithPose,
    }

    /// All that a robot is among, or what changes of it.
    PlanningScene = "moveit_msgs/msg/PlanningScene" {
        name: String,
        robot_state: RobotState,
        robot_model_name: String,
        fixed_frame_transforms: Vec<TransformStamped>,
        allowed_collision_matrix: AllowedCollisionMatrix,
        link_padding: Vec<LinkPadding>,
        link_scale: Vec<LinkScale>,
        object_colors: Vec<ObjectColor>,
        world: PlanningSceneWorld,
        is_diff: bool,
    }

    /// Which parts of a scene, one bit each.
    PlanningSceneComponents = "moveit_msgs/msg/PlanningSceneComponents" {
        components: u32,
    }

    /// 1 is success.
    MoveItErrorCodes = "moveit_msgs/msg/MoveItErrorCodes" {
        val: i32,
        message: String,
        source: String,
    }

    /// A joint about a value.
    JointConstraint = "moveit_msgs/msg/JointConstraint" {
        joint_name: String,
        position: f64,
        tolerance_above: f64,
        tolerance_below: f64,
        weight: f64,
    }

    /// Where something may be.
    BoundingVolume = "moveit_msgs/msg/BoundingVolume" {
        primitives: Vec<SolidPrimitive>,
        primitive_poses: Vec<Pose>,
        meshes: Vec<Mesh>,
        mesh_poses: Vec<Pose>,
    }

    /// A point of a link in a region.
    PositionConstraint = "moveit_msgs/msg/PositionConstraint" {
        header: Header,
        link_name: String,
        target_point_offset: Vector3,
        constraint_region: BoundingVolume,
        weight: f64,
    }

    /// A link turned as said, within tolerances.
    OrientationConstraint = "moveit_msgs/msg/OrientationConstraint" {
        header: Header,
        orientation: Quaternion,
        link_name: String,
        absolute_x_axis_tolerance: f64,
        absolute_y_axis_tolerance: f64,
        absolute_z_axis_tolerance: f64,
        parameterization: u8,
        weight: f64,
    }

    /// A target that a sensor sees.
    VisibilityConstraint = "moveit_msgs/msg/VisibilityConstraint" {
        target_radius: f64,
        target_pose: PoseStamped,
        cone_sides: i32,
        sensor_pose: PoseStamped,
        max_view_angle: f64,
        max_range_angle: f64,
        sensor_view_direction: u8,
        weight: f64,
    }

    /// All of them hold.
    Constraints = "moveit_msgs/msg/Constraints" {
        name: String,
        joint_constraints: Vec<JointConstraint>,
        position_constraints: Vec<PositionConstraint>,
        orientation_constraints: Vec<OrientationConstraint>,
        visibility_constraints: Vec<VisibilityConstraint>,
    }

    /// One after another.
    TrajectoryConstraints = "moveit_msgs/msg/TrajectoryConstraints" {
        constraints: Vec<Constraints>,
    }

    /// Where a mobile base may go.
    WorkspaceParameters = "moveit_msgs/msg/WorkspaceParameters" {
        header: Header,
        min_corner: Vector3,
        max_corner: Vector3,
    }

    /// How a frame moves.
    CartesianPoint = "moveit_msgs/msg/CartesianPoint" {
        pose: Pose,
        velocity: Twist,
        acceleration: Accel,
    }

    /// ... and when.
    CartesianTrajectoryPoint = "moveit_msgs/msg/CartesianTrajectoryPoint" {
        point: CartesianPoint,
        time_from_start: Duration,
    }

    /// ... all the way.
    CartesianTrajectory = "moveit_msgs/msg/CartesianTrajectory" {
        header: Header,
        tracked_frame: String,
        points: Vec<CartesianTrajectoryPoint>,
    }

    /// Paths of either kind.
    GenericTrajectory = "moveit_msgs/msg/GenericTrajectory" {
        header: Header,
        joint_trajectory: Vec<JointTrajectory>,
        cartesian_trajectory: Vec<CartesianTrajectory>,
    }

    /// What a planner is asked.
    MotionPlanRequest = "moveit_msgs/msg/MotionPlanRequest" {
        workspace_parameters: WorkspaceParameters,
        start_state: RobotState,
        goal_constraints: Vec<Constraints>,
        path_constraints: Constraints,
        trajectory_constraints: TrajectoryConstraints,
        reference_trajectories: Vec<GenericTrajectory>,
        pipeline_id: String,
        planner_id: String,
        group_name: String,
        num_planning_attempts: i32,
        allowed_planning_time: f64,
        max_velocity_scaling_factor: f64,
        max_acceleration_scaling_factor: f64,
        cartesian_speed_limited_link: String,
        max_cartesian_speed: f64,
    }

    /// What it answers.
    MotionPlanResponse = "moveit_msgs/msg/MotionPlanResponse" {
        trajectory_start: RobotState,
        group_name: String,
        trajectory: RobotTrajectory,
        planning_time: f64,
        error_code: MoveItErrorCodes,
    }

    /// Asks for a path.
    GetMotionPlanRequest = "moveit_msgs/srv/GetMotionPlan_Request" {
        motion_plan_request: MotionPlanRequest,
    }

    /// The path.
    GetMotionPlanResponse = "moveit_msgs/srv/GetMotionPlan_Response" {
        motion_plan_response: MotionPlanResponse,
    }

    /// A scene to be taken, or what changes of it.
    ApplyPlanningSceneRequest = "moveit_msgs/srv/ApplyPlanningScene_Request" {
        scene: PlanningScene,
    }

    /// Whether it was.
    ApplyPlanningSceneResponse = "moveit_msgs/srv/ApplyPlanningScene_Response" {
        success: bool,
    }

    /// Asks for parts of the scene.
    GetPlanningSceneRequest = "moveit_msgs/srv/GetPlanningScene_Request" {
        components: PlanningSceneComponents,
    }

    /// The scene.
    GetPlanningSceneResponse = "moveit_msgs/srv/GetPlanningScene_Response" {
        scene: PlanningScene,
    }
}

services! {
    /// A path for a request.
    GetMotionPlan = "moveit_msgs/srv/GetMotionPlan" "moveit_msgs/srv/GetMotionPlan_Event": GetMotionPlanRequest => GetMotionPlanResponse;
    /// A change of the scene.
    ApplyPlanningScene = "moveit_msgs/srv/ApplyPlanningScene" "moveit_msgs/srv/ApplyPlanningScene_Event": ApplyPlanningSceneRequest => ApplyPlanningSceneResponse;
    /// The scene as it is.
    GetPlanningScene = "moveit_msgs/srv/GetPlanningScene" "moveit_msgs/srv/GetPlanningScene_Event": GetPlanningSceneRequest => GetPlanningSceneResponse;
}
