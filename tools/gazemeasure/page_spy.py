"""What the page benchmark adds to the page from outside: times of its handlers, ages of pictures.

Injected before the page's own scripts. All times are ms of the computer's wall clock.
"""

from gazemeasure.stamped_camera import READ

SPY = f"""(() => {{
  const readStamp = {READ};
  const now = () => performance.timeOrigin + performance.now();
  const spy = window.spy = {{said: [], over: [], late: [], drawn: []}};
  const send = WebSocket.prototype.send;
  let edge = 0;
  WebSocket.prototype.send = function (data) {{
    if (typeof data === "string" && data.startsWith('{{"k":"cmd"')) {{
      const message = JSON.parse(data);
      if (message.edge !== edge) spy.said.push(now());
      edge = message.edge;
    }}
    return send.call(this, data);
  }};
  let under = "";
  addEventListener("pointermove", (event) => {{
    const at = now(), name = event.target.closest?.(".target")?.id ?? "";
    spy.late.push(performance.now() - event.timeStamp);
    if (name !== under) spy.over.push([at, name]);
    under = name;
  }}, true);
  const show = ImageBitmapRenderingContext.prototype.transferFromImageBitmap;
  ImageBitmapRenderingContext.prototype.transferFromImageBitmap = function (bitmap) {{
    const at = now(), stamp = readStamp(bitmap);
    if (stamp !== null) spy.drawn.push([at, (Math.round(at) - stamp) & 0xffff, bitmap.width]);
    return show.call(this, bitmap);
  }};
}})()"""

# Empties what was noted and returns it.
TAKE = """() => {
  const taken = {...window.spy};
  Object.assign(window.spy, {said: [], over: [], late: [], drawn: []});
  return taken;
}"""
