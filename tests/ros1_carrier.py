# SPDX-License-Identifier: MIT
"""A carrier for ROS 1's own Python: cmd_vel in, odometry out; its wheels lag and lose a share of speed."""

import math

import rospy
from geometry_msgs.msg import Twist
from nav_msgs.msg import Odometry

RATE = 100.0  # [Hz]
LAG = 0.1  # [s]
GRIP = (0.95, 0.9, 1.05)  # share of speed that is left: forward, left, yaw


def main() -> None:
    """Until the end."""
    rospy.init_node("carrier")
    odometry = rospy.Publisher("/odom", Odometry, queue_size=10)
    wanted, speed, eta = [0.0, 0.0, 0.0], [0.0, 0.0, 0.0], [1.0, 2.0, 0.5]

    def hear(message: Twist) -> None:
        wanted[:] = [message.linear.x, message.linear.y, message.angular.z]

    rospy.Subscriber("/cmd_vel", Twist, hear, queue_size=1, tcp_nodelay=True)
    beat, k = rospy.Rate(RATE), 0
    while not rospy.is_shutdown():
        for i in range(3):
            speed[i] += (wanted[i] - speed[i]) * -math.expm1(-1.0 / (RATE * LAG))
        u, v, r = (share * s for share, s in zip(GRIP, speed, strict=True))
        c, s = math.cos(eta[2]), math.sin(eta[2])
        eta[0] += (c * u - s * v) / RATE
        eta[1] += (s * u + c * v) / RATE
        eta[2] += r / RATE
        k += 1
        if k % 4 == 0:
            message = Odometry()
            message.header.stamp, message.header.frame_id = rospy.Time.now(), "carrier_odom"
            message.pose.pose.position.x, message.pose.pose.position.y = eta[0], eta[1]
            message.pose.pose.orientation.z = math.sin(eta[2] / 2)
            message.pose.pose.orientation.w = math.cos(eta[2] / 2)
            odometry.publish(message)
        try:
            beat.sleep()
        except rospy.ROSInterruptException:
            return


if __name__ == "__main__":
    main()
