// The times of the driver's intent, and their names.

/** Targets that move the chair. Every other target name is a button, except "stop". */
export const DRIVE = ["forward", "left", "right", "backward"];
/** Tiles of modes that plug-ins bring: held as a direction is, whatever "mode" says. */
export const isPlugin = (name) => name?.startsWith("plugin-") ?? false;
export const isDrive = (name) => DRIVE.includes(name) || isPlugin(name);
/** Reading what a menu offers takes its time: its dwell is so much longer. */
export const MENU_FACTOR = 2;
export const isMenu = (name) => name === "back" || name.startsWith("tile-");
/** Every button: after the page has changed, none acts by gaze before the gaze was on none. */
export const ALL = "*";
/** A step is said again for this long, so that one lost message does not lose the step. */
export const STEP_REPEAT_MS = 150;
/** After a stop the gaze must be off every drive target for this long. */
export const REST_MS = 300;
/** A shorter press in continuous mode earns the hint to keep pressing. */
export const TAP_MS = 200;
