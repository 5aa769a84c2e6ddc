"""The contract tests of plug-ins, anyone's: `gazechair plugin check`, in the virtual chair."""
