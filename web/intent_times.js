// The times of the driver's intent, and their names.

/** Targets that move the chair. Every other target name is a button, except "stop". */
export const DRIVE = ["forward", "left", "right", "backward"];
/** Tiles of plug-in modes: held like a direction, in every drive mode. */
export const isPlugin = (name) => name?.startsWith("plugin-") ?? false;
export const isDrive = (name) => DRIVE.includes(name) || isPlugin(name);
/** Factor on the dwell in a menu, which takes time to read. */
export const MENU_FACTOR = 2;
export const isMenu = (name) => name === "back" || name.startsWith("tile-");
/** Every button: after the page has changed, gaze must leave all buttons before one acts. */
export const ALL = "*";
/** A step is repeated for this long, so that one lost message does not lose the step. */
export const STEP_REPEAT_MS = 150;
/** After a stop the gaze must be off every drive target for this long. */
export const REST_MS = 300;
/** A shorter press in continuous mode shows the hint to keep pressing. */
export const TAP_MS = 200;
