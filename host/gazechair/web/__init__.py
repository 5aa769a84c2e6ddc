"""The web server of the pages: HTTP for files, a socket for control, one for the picture."""

from gazechair.web.server import PageParts, WebError, WebServer

__all__ = ["PageParts", "WebError", "WebServer"]
