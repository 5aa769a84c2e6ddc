# A small host: sessions, and frames that a test makes by hand. Runs on MicroPython too.

from gazelink import arcs, codes, frame, messages

FAR = messages.CLEAR_FAR
STOP = (codes.STOP, codes.CONTINUOUS, 0, codes.DRIVER, 0, 0, 0, 1000, 0)


# Values of a CLEARANCE frame: what is blocked, and nothing else within range unless said.
def clearance(
    blocked, source, age_ms, distances=(FAR, FAR, FAR, FAR), unseen=0, ways=arcs.ALL_FAR, views=0
):
    return (blocked, unseen, source) + tuple(distances) + (age_ms, views, bytes(ways))


class SmallHost:
    # `put(buf, n)` takes bytes for the board, `received(kind, buf)` its frames but for HELLO.

    def __init__(self, session):
        self.stamp = 0  # of the board's newest frame
        self.passed_ms = 0  # from the one before
        self._boot = 0  # of the board that echoed our HELLO
        self._order_number = 0
        self.renew(session)

    # Nothing is agreed on; the next HELLO asks for `session`.
    def renew(self, session):
        self.session = session
        self.keys = frame.Session()
        self.encoder = frame.Encoder()
        self.decoder = frame.Decoder()
        self.encoder.session = self.decoder.session = self.keys

    def say_hello(self, session=None, schema=None):
        if session is not None:
            self.session = session
        if schema is None:
            schema = frame.schema_hash()
        self.send(messages.HELLO, (0, 0, schema, self.session, 0, 0, 1, 0, b"tests"))

    def send(self, message, values):
        message.pack(self.encoder.body, values)
        self.put(self.encoder.wire, self.encoder.finish(message, self.stamp))

    # The values of a new order, to be sent some times.
    def next_order(self, action, owner):
        self._order_number = self._order_number % 255 + 1
        return (action, self._order_number, owner)

    def hear(self, data, n):
        for k in range(n):
            if self.decoder.feed(data[k]):
                self._hear(self.decoder.buf)

    def _hear(self, buf):
        kind = buf[messages.TYPE_AT]
        if kind == messages.HELLO.type_id:
            self.greeted(messages.HELLO.unpack(buf))
            return
        stamp = frame.u16(buf, messages.STAMP_AT)
        if kind == messages.NONCE.type_id:
            begun = messages.NONCE.unpack(buf)
            if begun["session"] == self.session and not self.keys.live:
                self.keys.begin(self.session, self._boot, begun["nonce"], begun["epoch"], stamp)
        self.keys.advance(stamp)
        self.passed_ms = (stamp - self.stamp) & 0xFFFF
        self.stamp = stamp
        self.received(kind, buf)

    # The board's HELLO: the echo of ours, or that of a board which knows no session.
    def greeted(self, hello):
        if hello["session"] == self.session:
            self._boot = hello["boot"]
        elif self.keys.live:
            self.lost()

    def lost(self):
        self.keys.end()
