"""Everything that reaches into rospy's internals."""
