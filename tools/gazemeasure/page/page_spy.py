"""Instruments the page for its benchmark: times of its handlers, ages of pictures.

`install` adds it to the page before its own scripts, and to the thread that draws its pictures.
All times are ms of the computer's wall clock.
"""

from __future__ import annotations

from playwright.sync_api import Page

from gazemeasure.page.stamped_camera import READ

_WORKER = "picture_worker.js"
_CHANNEL = "gazemeasure"

_PAGE = f"""(() => {{
  const now = () => performance.timeOrigin + performance.now();
  const spy = window.spy = {{sent: [], over: [], late: [], drawn: []}};
  const send = WebSocket.prototype.send;
  let edge = 0;
  WebSocket.prototype.send = function (data) {{
    if (typeof data === "string" && data.startsWith('{{"k":"cmd"')) {{
      const message = JSON.parse(data);
      if (message.edge !== edge) spy.sent.push(now());
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
  new BroadcastChannel("{_CHANNEL}").onmessage = (event) => spy.drawn.push(event.data);
}})()"""

_DRAWING = f"""(() => {{
  const readStamp = {READ};
  const now = () => performance.timeOrigin + performance.now();
  const channel = new BroadcastChannel("{_CHANNEL}");
  const show = ImageBitmapRenderingContext.prototype.transferFromImageBitmap;
  ImageBitmapRenderingContext.prototype.transferFromImageBitmap = function (bitmap) {{
    const at = now(), stamp = readStamp(bitmap), width = bitmap.width;
    if (stamp !== null) {{
      channel.postMessage([at, (Math.round(at) - stamp) & 0xffff, width]);
    }}
    return show.call(this, bitmap);
  }};
}})()"""

# Returns the records and clears them.
TAKE = """() => {
  const taken = {...window.spy};
  Object.assign(window.spy, {sent: [], over: [], late: [], drawn: []});
  return taken;
}"""


def install(page: Page) -> None:
    """Reload the page with instruments; its host must run. Error when it starts no thread."""
    page.add_init_script(_PAGE)
    page.reload()
    if not any(worker.url.endswith(_WORKER) for worker in page.workers):
        page.wait_for_event("worker", lambda worker: worker.url.endswith(_WORKER))
    page.workers[-1].evaluate(_DRAWING)
