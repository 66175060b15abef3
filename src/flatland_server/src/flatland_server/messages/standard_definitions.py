"""The fields and constants of ROS's common messages, for machines without ROS.

Their names, types and order must be those of ROS: the MD5 sum of a type is computed from them, and
a test compares it with ROS's own. The form is a shorthand of the .msg
grammar. A line defines a type; indented lines continue it. Its parts, separated by semicolons, are
a type with one or more fields or constants:

    MapMetaData: time map_load_time; float32 resolution; uint32 width height
    NavSatStatus: int8 STATUS_NO_FIX=-1 STATUS_FIX=0 ...; int8 status; uint16 service
"""

from functools import lru_cache
from typing import Dict, Iterator

_SHORTHANDS = {
    "ackermann_msgs": """
AckermannDrive: float32 steering_angle steering_angle_velocity speed acceleration jerk
AckermannDriveStamped: std_msgs/Header header; AckermannDrive drive
""",
    "actionlib_msgs": """
GoalID: time stamp; string id
GoalStatus: GoalID goal_id; uint8 status;
    uint8 PENDING=0 ACTIVE=1 PREEMPTED=2 SUCCEEDED=3 ABORTED=4 REJECTED=5 PREEMPTING=6 RECALLING=7
    RECALLED=8 LOST=9; string text
GoalStatusArray: std_msgs/Header header; GoalStatus[] status_list
""",
    "diagnostic_msgs": """
DiagnosticArray: std_msgs/Header header; DiagnosticStatus[] status
DiagnosticStatus: byte OK=0 WARN=1 ERROR=2 STALE=3; byte level;
    string name message hardware_id; KeyValue[] values
KeyValue: string key value
""",
    "geometry_msgs": """
Accel: Vector3 linear angular
AccelStamped: std_msgs/Header header; Accel accel
AccelWithCovariance: Accel accel; float64[36] covariance
AccelWithCovarianceStamped: std_msgs/Header header; AccelWithCovariance accel
Inertia: float64 m; Vector3 com; float64 ixx ixy ixz iyy iyz izz
InertiaStamped: std_msgs/Header header; Inertia inertia
Point: float64 x y z
Point32: float32 x y z
PointStamped: std_msgs/Header header; Point point
Polygon: Point32[] points
PolygonStamped: std_msgs/Header header; Polygon polygon
Pose: Point position; Quaternion orientation
Pose2D: float64 x y theta
PoseArray: std_msgs/Header header; Pose[] poses
PoseStamped: std_msgs/Header header; Pose pose
PoseWithCovariance: Pose pose; float64[36] covariance
PoseWithCovarianceStamped: std_msgs/Header header; PoseWithCovariance pose
Quaternion: float64 x y z w
QuaternionStamped: std_msgs/Header header; Quaternion quaternion
Transform: Vector3 translation; Quaternion rotation
TransformStamped: std_msgs/Header header; string child_frame_id; Transform transform
Twist: Vector3 linear angular
TwistStamped: std_msgs/Header header; Twist twist
TwistWithCovariance: Twist twist; float64[36] covariance
TwistWithCovarianceStamped: std_msgs/Header header; TwistWithCovariance twist
Vector3: float64 x y z
Vector3Stamped: std_msgs/Header header; Vector3 vector
Wrench: Vector3 force torque
WrenchStamped: std_msgs/Header header; Wrench wrench
""",
    "nav_msgs": """
GridCells: std_msgs/Header header; float32 cell_width cell_height; geometry_msgs/Point[] cells
MapMetaData: time map_load_time; float32 resolution; uint32 width height;
    geometry_msgs/Pose origin
OccupancyGrid: std_msgs/Header header; MapMetaData info; int8[] data
Odometry: std_msgs/Header header; string child_frame_id; geometry_msgs/PoseWithCovariance pose;
    geometry_msgs/TwistWithCovariance twist
Path: std_msgs/Header header; geometry_msgs/PoseStamped[] poses
""",
    "rosgraph_msgs": """
Clock: time clock
Log: byte DEBUG=1 INFO=2 WARN=4 ERROR=8 FATAL=16; std_msgs/Header header; byte level;
    string name msg file function; uint32 line; string[] topics
""",
    "sensor_msgs": """
BatteryState: uint8 POWER_SUPPLY_STATUS_UNKNOWN=0 POWER_SUPPLY_STATUS_CHARGING=1
    POWER_SUPPLY_STATUS_DISCHARGING=2 POWER_SUPPLY_STATUS_NOT_CHARGING=3
    POWER_SUPPLY_STATUS_FULL=4 POWER_SUPPLY_HEALTH_UNKNOWN=0 POWER_SUPPLY_HEALTH_GOOD=1
    POWER_SUPPLY_HEALTH_OVERHEAT=2 POWER_SUPPLY_HEALTH_DEAD=3 POWER_SUPPLY_HEALTH_OVERVOLTAGE=4
    POWER_SUPPLY_HEALTH_UNSPEC_FAILURE=5 POWER_SUPPLY_HEALTH_COLD=6
    POWER_SUPPLY_HEALTH_WATCHDOG_TIMER_EXPIRE=7 POWER_SUPPLY_HEALTH_SAFETY_TIMER_EXPIRE=8
    POWER_SUPPLY_TECHNOLOGY_UNKNOWN=0 POWER_SUPPLY_TECHNOLOGY_NIMH=1
    POWER_SUPPLY_TECHNOLOGY_LION=2 POWER_SUPPLY_TECHNOLOGY_LIPO=3 POWER_SUPPLY_TECHNOLOGY_LIFE=4
    POWER_SUPPLY_TECHNOLOGY_NICD=5 POWER_SUPPLY_TECHNOLOGY_LIMN=6; std_msgs/Header header;
    float32 voltage temperature current charge capacity design_capacity percentage;
    uint8 power_supply_status power_supply_health power_supply_technology; bool present;
    float32[] cell_voltage cell_temperature; string location serial_number
CameraInfo: std_msgs/Header header; uint32 height width; string distortion_model; float64[] D;
    float64[9] K R; float64[12] P; uint32 binning_x binning_y; RegionOfInterest roi
ChannelFloat32: string name; float32[] values
CompressedImage: std_msgs/Header header; string format; uint8[] data
FluidPressure: std_msgs/Header header; float64 fluid_pressure variance
Illuminance: std_msgs/Header header; float64 illuminance variance
Image: std_msgs/Header header; uint32 height width; string encoding; uint8 is_bigendian;
    uint32 step; uint8[] data
Imu: std_msgs/Header header; geometry_msgs/Quaternion orientation;
    float64[9] orientation_covariance; geometry_msgs/Vector3 angular_velocity;
    float64[9] angular_velocity_covariance; geometry_msgs/Vector3 linear_acceleration;
    float64[9] linear_acceleration_covariance
JointState: std_msgs/Header header; string[] name; float64[] position velocity effort
Joy: std_msgs/Header header; float32[] axes; int32[] buttons
JoyFeedback: uint8 TYPE_LED=0 TYPE_RUMBLE=1 TYPE_BUZZER=2; uint8 type id; float32 intensity
JoyFeedbackArray: JoyFeedback[] array
LaserEcho: float32[] echoes
LaserScan: std_msgs/Header header;
    float32 angle_min angle_max angle_increment time_increment scan_time range_min range_max;
    float32[] ranges intensities
MagneticField: std_msgs/Header header; geometry_msgs/Vector3 magnetic_field;
    float64[9] magnetic_field_covariance
MultiDOFJointState: std_msgs/Header header; string[] joint_names;
    geometry_msgs/Transform[] transforms; geometry_msgs/Twist[] twist;
    geometry_msgs/Wrench[] wrench
MultiEchoLaserScan: std_msgs/Header header;
    float32 angle_min angle_max angle_increment time_increment scan_time range_min range_max;
    LaserEcho[] ranges intensities
NavSatFix: std_msgs/Header header; NavSatStatus status; float64 latitude longitude altitude;
    float64[9] position_covariance;
    uint8 COVARIANCE_TYPE_UNKNOWN=0 COVARIANCE_TYPE_APPROXIMATED=1
    COVARIANCE_TYPE_DIAGONAL_KNOWN=2 COVARIANCE_TYPE_KNOWN=3; uint8 position_covariance_type
NavSatStatus: int8 STATUS_NO_FIX=-1 STATUS_FIX=0 STATUS_SBAS_FIX=1 STATUS_GBAS_FIX=2;
    int8 status; uint16 SERVICE_GPS=1 SERVICE_GLONASS=2 SERVICE_COMPASS=4 SERVICE_GALILEO=8;
    uint16 service
PointCloud: std_msgs/Header header; geometry_msgs/Point32[] points; ChannelFloat32[] channels
PointCloud2: std_msgs/Header header; uint32 height width; PointField[] fields;
    bool is_bigendian; uint32 point_step row_step; uint8[] data; bool is_dense
PointField: uint8 INT8=1 UINT8=2 INT16=3 UINT16=4 INT32=5 UINT32=6 FLOAT32=7 FLOAT64=8;
    string name; uint32 offset; uint8 datatype; uint32 count
Range: std_msgs/Header header; uint8 ULTRASOUND=0 INFRARED=1; uint8 radiation_type;
    float32 field_of_view min_range max_range range
RegionOfInterest: uint32 x_offset y_offset height width; bool do_rectify
RelativeHumidity: std_msgs/Header header; float64 relative_humidity variance
Temperature: std_msgs/Header header; float64 temperature variance
TimeReference: std_msgs/Header header; time time_ref; string source
""",
    "std_msgs": """
Bool: bool data
Byte: byte data
ByteMultiArray: MultiArrayLayout layout; byte[] data
Char: char data
ColorRGBA: float32 r g b a
Duration: duration data
Empty:
Float32: float32 data
Float32MultiArray: MultiArrayLayout layout; float32[] data
Float64: float64 data
Float64MultiArray: MultiArrayLayout layout; float64[] data
Header: uint32 seq; time stamp; string frame_id
Int16: int16 data
Int16MultiArray: MultiArrayLayout layout; int16[] data
Int32: int32 data
Int32MultiArray: MultiArrayLayout layout; int32[] data
Int64: int64 data
Int64MultiArray: MultiArrayLayout layout; int64[] data
Int8: int8 data
Int8MultiArray: MultiArrayLayout layout; int8[] data
MultiArrayDimension: string label; uint32 size stride
MultiArrayLayout: MultiArrayDimension[] dim; uint32 data_offset
String: string data
Time: time data
UInt16: uint16 data
UInt16MultiArray: MultiArrayLayout layout; uint16[] data
UInt32: uint32 data
UInt32MultiArray: MultiArrayLayout layout; uint32[] data
UInt64: uint64 data
UInt64MultiArray: MultiArrayLayout layout; uint64[] data
UInt8: uint8 data
UInt8MultiArray: MultiArrayLayout layout; uint8[] data
""",
    "tf2_msgs": """
TF2Error: uint8 NO_ERROR=0 LOOKUP_ERROR=1 CONNECTIVITY_ERROR=2 EXTRAPOLATION_ERROR=3
    INVALID_ARGUMENT_ERROR=4 TIMEOUT_ERROR=5 TRANSFORM_ERROR=6; uint8 error; string error_string
TFMessage: geometry_msgs/TransformStamped[] transforms
""",
    "visualization_msgs": """
ImageMarker: uint8 CIRCLE=0 LINE_STRIP=1 LINE_LIST=2 POLYGON=3 POINTS=4 ADD=0 REMOVE=1;
    std_msgs/Header header; string ns; int32 id type action; geometry_msgs/Point position;
    float32 scale; std_msgs/ColorRGBA outline_color; uint8 filled; std_msgs/ColorRGBA fill_color;
    duration lifetime; geometry_msgs/Point[] points; std_msgs/ColorRGBA[] outline_colors
InteractiveMarker: std_msgs/Header header; geometry_msgs/Pose pose; string name description;
    float32 scale; MenuEntry[] menu_entries; InteractiveMarkerControl[] controls
InteractiveMarkerControl: string name; geometry_msgs/Quaternion orientation;
    uint8 INHERIT=0 FIXED=1 VIEW_FACING=2; uint8 orientation_mode;
    uint8 NONE=0 MENU=1 BUTTON=2 MOVE_AXIS=3 MOVE_PLANE=4 ROTATE_AXIS=5 MOVE_ROTATE=6 MOVE_3D=7
    ROTATE_3D=8 MOVE_ROTATE_3D=9; uint8 interaction_mode; bool always_visible; Marker[] markers;
    bool independent_marker_orientation; string description
InteractiveMarkerFeedback: std_msgs/Header header; string client_id marker_name control_name;
    uint8 KEEP_ALIVE=0 POSE_UPDATE=1 MENU_SELECT=2 BUTTON_CLICK=3 MOUSE_DOWN=4 MOUSE_UP=5;
    uint8 event_type; geometry_msgs/Pose pose; uint32 menu_entry_id;
    geometry_msgs/Point mouse_point; bool mouse_point_valid
InteractiveMarkerInit: string server_id; uint64 seq_num; InteractiveMarker[] markers
InteractiveMarkerPose: std_msgs/Header header; geometry_msgs/Pose pose; string name
InteractiveMarkerUpdate: string server_id; uint64 seq_num; uint8 KEEP_ALIVE=0 UPDATE=1;
    uint8 type; InteractiveMarker[] markers; InteractiveMarkerPose[] poses; string[] erases
Marker: uint8 ARROW=0 CUBE=1 SPHERE=2 CYLINDER=3 LINE_STRIP=4 LINE_LIST=5 CUBE_LIST=6
    SPHERE_LIST=7 POINTS=8 TEXT_VIEW_FACING=9 MESH_RESOURCE=10 TRIANGLE_LIST=11 ADD=0 MODIFY=0
    DELETE=2 DELETEALL=3; std_msgs/Header header; string ns; int32 id type action;
    geometry_msgs/Pose pose; geometry_msgs/Vector3 scale; std_msgs/ColorRGBA color;
    duration lifetime; bool frame_locked; geometry_msgs/Point[] points;
    std_msgs/ColorRGBA[] colors; string text mesh_resource; bool mesh_use_embedded_materials
MarkerArray: Marker[] markers
MenuEntry: uint32 id parent_id; string title command; uint8 FEEDBACK=0 ROSRUN=1 ROSLAUNCH=2;
    uint8 command_type
""",
}


@lru_cache(maxsize=1)
def standard_definitions() -> Dict[str, str]:
    """The definitions in the .msg grammar, by name."""
    definitions: Dict[str, str] = {}
    for package, shorthand in _SHORTHANDS.items():
        definitions.update(written_out(package, shorthand))
    return definitions


def written_out(package: str, shorthand: str) -> Dict[str, str]:
    """The definitions of a package in the .msg grammar, by name."""
    lines = shorthand.strip().replace("\n    ", " ").splitlines()
    return {
        f"{package}/{name.strip()}": "".join(_lines(parts))
        for name, _, parts in (line.partition(":") for line in lines)
    }


def _lines(parts: str) -> Iterator[str]:
    """The lines of a definition."""
    for part in filter(None, map(str.strip, parts.split(";"))):
        kind, *names = part.split()
        yield from (f"{kind} {name}\n" for name in names)
