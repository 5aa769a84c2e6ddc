# Boards: the one place where hardware is touched; every board offers the same few calls.
