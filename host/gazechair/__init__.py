"""The host daemon and the `gazechair` command: serial link, lidar, camera, arbiter, web server."""
