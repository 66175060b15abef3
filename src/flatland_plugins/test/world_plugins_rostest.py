"""Over a real master: the plugins of the world."""

import math
import unittest

import rospy
import rostest_case
from geometry_msgs.msg import PoseArray
from readings import pose_of
from robots import Topic
from rostest_tools import Recorder
from visualization_msgs.msg import Marker, MarkerArray
from waiting import wait_until


class RandomWall(unittest.TestCase):
    """In a hall of 4 x 4 m about (20, 0), copies of two of the walls are 0.5 m nearer."""

    def lines(self):
        """The hall's walls as rviz gets them: the sets of their ends."""
        recorder = Recorder("/flatland_server/debug/layer/hall", MarkerArray)
        (marker,) = wait_until(lambda: recorder.messages, "the walls")[0].markers
        recorder.close()
        self.assertEqual((marker.type, marker.header.frame_id), (Marker.LINE_LIST, "map"))
        ends = [(round(p.x, 6), round(p.y, 6)) for p in marker.points]
        return [frozenset(pair) for pair in zip(ends[::2], ends[1::2])]

    def test_markers_show_two_walls_more(self):
        corners = [(18.0, -2.0), (22.0, -2.0), (22.0, 2.0), (18.0, 2.0)]
        walls = {frozenset(pair) for pair in zip(corners, corners[1:] + corners[:1])}
        copies = {
            frozenset({(18.0, -1.5), (22.0, -1.5)}),
            frozenset({(21.5, -2.0), (21.5, 2.0)}),
            frozenset({(18.0, 1.5), (22.0, 1.5)}),
            frozenset({(18.5, -2.0), (18.5, 2.0)}),
        }
        lines = self.lines()
        self.assertEqual(len(lines), 6)
        self.assertEqual(set(lines) - copies, walls)
        self.assertEqual(len(set(lines) & copies), 2)


class Crowd(rostest_case.ListeningCase):
    """One walks east and one stands; one of another crowd walks south, on legs."""

    published = (
        Topic("crowd/poses", PoseArray, 20.0, "map"),
        Topic("slow/poses", PoseArray, 25.0, "world"),
    )

    def two_moments(self, name):
        """Messages a second apart, at constant speeds."""
        poses = self.recorders[name]
        first = poses.next(holds=lambda m: m.header.stamp.to_sec() > 6.0)
        then = first.header.stamp + rospy.Duration(1)
        last = poses.next(holds=lambda m: m.header.stamp >= then)
        return first, last, (last.header.stamp - first.header.stamp).to_sec()

    def test_pedestrians_walk_to_their_goals_at_their_speeds(self):
        first, last, elapsed = self.two_moments("/crowd/poses")
        (x, y, yaw), porter = map(pose_of, first.poses)
        # From a standstill, relaxing with a time constant of half a second, v = 1.34 (1 - e^-2t).
        travelled = 1.34 * (first.header.stamp.to_sec() - 0.5)
        self.assert_pose((x, y, yaw), (40.0 + travelled, 0.0, 0.0), delta=0.05)
        self.assert_pose(pose_of(last.poses[0]), (x + 1.34 * elapsed, 0.0, 0.0), delta=1e-3)
        self.assert_pose(porter, (40.0, 10.0, 1.0))
        self.assert_pose(pose_of(last.poses[1]), (40.0, 10.0, 1.0))

        first, last, elapsed = self.two_moments("/slow/poses")
        (x, y, _), (pose,) = pose_of(first.poses[0]), last.poses
        south = (40.0, y - 0.8 * elapsed, -math.pi / 2)
        self.assert_pose(pose_of(pose), south, delta=1e-3)

    def test_markers_walk_along(self):
        markers = Recorder("/flatland_server/debug/model/crowd_0", MarkerArray)
        self.addCleanup(markers.close)
        (first, *_), (last, *_) = markers.next().markers, markers.next(15).markers
        self.assertEqual(first.header.frame_id, "map")
        self.assertGreater(last.pose.position.x - first.pose.position.x, 0.3)
        pose = self.recorders["/crowd/poses"].messages[-1].poses[0]
        self.assertAlmostEqual(last.pose.position.x, pose.position.x, delta=0.3)
