"""A proxy before a PostgreSQL server that cuts all connections halfway through a payload."""

import os
import pathlib
import socket
import tempfile
import threading

LARGE_BYTES = 2 << 10  # Larger than every row but payloads and codebooks.
SOCKET = ".s.PGSQL.5432"


class Proxy:
    """Listens on a socket in `folder`. Once armed, it cuts at the next payload: the connections are closed, or
    they stay open and silent. New connections fare alike until the proxy is mended; cut ones stay cut."""

    def __init__(self, server_folder, is_silent):
        self.scratch = tempfile.TemporaryDirectory(prefix="cairn_proxy_")
        self.folder = self.scratch.name
        self.server_path = os.path.join(server_folder, SOCKET)
        self.is_silent = is_silent
        self.is_armed = self.is_cut = False
        self.open = []
        self.silent = []  # Held, because a socket that nobody holds is closed.
        self.lock = threading.Lock()  # Guards the members above that change.
        self.listener = socket.socket(socket.AF_UNIX)
        self.listener.bind(str(pathlib.Path(self.folder) / SOCKET))
        self.listener.listen(64)
        threading.Thread(target=self._accept, daemon=True).start()

    def arm(self):
        self.is_armed = True

    def mend(self):
        self.is_armed = self.is_cut = False

    def close(self):
        self.listener.close()
        self._cut_all(is_silent=False)
        for client in self.silent:
            client.close()
        self.scratch.cleanup()

    def _accept(self):
        while True:
            try:
                client, _ = self.listener.accept()
            except OSError:
                return  # The proxy was closed.
            if self.is_cut:
                self._abandon(client)
            else:
                self._connect(client)

    def _connect(self, client):
        server = socket.socket(socket.AF_UNIX)
        try:
            server.connect(self.server_path)
        except OSError:
            client.close()
            server.close()
            return
        with self.lock:
            self.open.append((client, server))
        threading.Thread(target=self._relay_requests, args=(client, server), daemon=True).start()
        threading.Thread(target=self._relay_answers, args=(client, server), daemon=True).start()

    def _relay_requests(self, client, server):
        try:
            while data := client.recv(65536):
                server.sendall(data)
        except OSError:
            pass
        self._end(server)

    def _relay_answers(self, client, server):
        """Passes whole messages: a letter, the length, the content."""
        stream = server.makefile("rb")
        try:
            while len(header := stream.read(5)) == 5:
                content = stream.read(int.from_bytes(header[1:], "big") - 4)
                if self.is_armed and len(content) >= LARGE_BYTES:
                    client.sendall(header + content[:len(content) // 2])
                    self.is_cut = True
                    self._cut_all(self.is_silent)
                    return
                client.sendall(header + content)
        except OSError:
            pass
        if (client, server) in self.open:  # Not cut.
            self._end(client)

    def _cut_all(self, is_silent):
        with self.lock:
            cut, self.open = self.open, []
        for client, server in cut:
            self._end(server)
            if is_silent:
                self.silent.append(client)
            else:
                self._end(client)

    def _abandon(self, client):
        if self.is_silent:
            self.silent.append(client)
        else:
            client.close()

    @staticmethod
    def _end(connection):
        try:
            connection.shutdown(socket.SHUT_RDWR)
        except OSError:
            pass  # The other side was faster.
