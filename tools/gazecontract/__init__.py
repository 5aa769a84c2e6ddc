"""Contract tests for any plug-in, in the virtual chair: `gazechair plugin check`."""
