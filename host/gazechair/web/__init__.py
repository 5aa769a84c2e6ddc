"""Web server of the pages: files and JSON over HTTP, a socket for control, one for the picture."""

from gazechair.web.server import PageParts, WebError, WebServer

__all__ = ["PageParts", "WebError", "WebServer"]
