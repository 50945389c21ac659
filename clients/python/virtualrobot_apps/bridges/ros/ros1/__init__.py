"""ROS 1: a node of its own with XML-RPC and TCPROS, and a master where there is none."""
