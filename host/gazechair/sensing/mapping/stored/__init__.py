"""Maps as files, as pictures, as files of ROS."""
