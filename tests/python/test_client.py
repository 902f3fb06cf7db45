"""cairn.Client against servers that do not answer."""

import os
import signal
import socket
import threading
import unittest

import cairn
import street
from street import expect_error


def setUpModule():
    global QUERY
    QUERY = street.FirstQuery().query()


class Silent(unittest.TestCase):
    """A server that takes connections and says nothing."""

    def setUp(self):
        self.listener = socket.create_server(("127.0.0.1", 0))
        self.addCleanup(self.listener.close)
        self.url = f"http://127.0.0.1:{self.listener.getsockname()[1]}"
        self.connections = []
        self.addCleanup(lambda: [connection.close() for connection in self.connections])

    def on_connection(self, act):
        def accept():
            self.connections.append(self.listener.accept()[0])
            self.connections[-1].recv(1)  # The request has begun.
            act()

        thread = threading.Thread(target=accept, daemon=True)
        thread.start()

    def test_ctrl_c_ends_the_request(self):
        self.on_connection(lambda: os.kill(os.getpid(), signal.SIGINT))
        client = cairn.Client(self.url, timeout_ms=3_600_000)
        with self.assertRaises(KeyboardInterrupt):
            client.localize(QUERY)

    def test_a_hangup_is_unavailable(self):
        self.on_connection(lambda: (self.listener.close(), self.connections[-1].close()))
        with expect_error(self, "unavailable", self.url):
            cairn.Client(self.url).localize(QUERY)

    def test_a_fork_must_make_a_client_of_its_own(self):
        client = cairn.Client(self.url)
        read, write = os.pipe()
        child = os.fork()
        if child == 0:
            try:
                client.localize(QUERY)
            except cairn.Error as error:
                os.write(write, f"{error.code} {error}".encode())
            os._exit(0)
        os.waitpid(child, 0)
        os.close(write)
        with os.fdopen(read) as pipe:
            said = pipe.read()
        self.assertRegex(said, "conflict client: .*fork")


if __name__ == "__main__":
    unittest.main()
