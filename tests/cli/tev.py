"""`render --tev` against a viewer of the test's own, which checks every byte that it gets: usage: tev.py ETENDUE SOURCES"""

import json
import os
import signal
import socket
import struct
import subprocess
import sys
import tempfile
import threading
import time
import unittest

from exr_pixels import read_exr

ETENDUE, SOURCES = sys.argv.pop(1), sys.argv.pop(1)
SCENE = SOURCES + "/scenes/cbox-sphere.xml"
COLORS = ["R", "G", "B", "StdErr.R", "StdErr.G", "StdErr.B", "SampleCount"]
CREATE, UPDATE = 4, 6


class Reader:
    """One packet's fields, in order; nothing may be left at the end."""

    def __init__(self, data):
        self.data, self.at = data, 0

    def take(self, layout):
        values = struct.unpack_from("<" + layout, self.data, self.at)
        self.at += struct.calcsize("<" + layout)
        return values if len(values) > 1 else values[0]

    def text(self):
        end = self.data.index(b"\0", self.at)
        value = self.data[self.at:end].decode()
        self.at = end + 1
        return value


class Picture:
    """What the viewer shows, made from the packets alone."""

    def __init__(self, packet):
        self.name = packet.text()
        self.width, self.height, count = packet.take("iii")
        self.channels = [packet.text() for _ in range(count)]
        assert self.width > 0 and self.height > 0 and count > 0
        self.values = {name: [0.0] * (self.width * self.height) for name in self.channels}
        self.rows = 0  # updated in this round: bands come from the top to the bottom
        self.rounds = 0

    def update(self, packet):
        assert packet.text() == self.name
        count = packet.take("i")
        assert [packet.text() for _ in range(count)] == self.channels
        x, y, width, height = packet.take("iiii")
        assert (x, width) == (0, self.width) and height > 0
        if y == 0:
            self.rows = 0
        assert y == self.rows and y + height <= self.height, (y, height, self.rows)
        offsets = [packet.take("q") for _ in range(count)]
        strides = [packet.take("q") for _ in range(count)]
        pixels = width * height
        floats = max(o + (pixels - 1) * s + 1 for o, s in zip(offsets, strides))
        data = struct.unpack_from("<%df" % floats, packet.data, packet.at)
        packet.at += 4 * floats
        # Every number that is sent belongs to one channel and one pixel.
        used = bytearray(floats)
        for name, offset, stride in zip(self.channels, offsets, strides):
            places = slice(offset, offset + (pixels - 1) * stride + 1, stride)
            assert not any(used[places]), "a number of two channels"
            used[places] = b"\1" * pixels
            self.values[name][y * width:y * width + pixels] = data[places]
        assert all(used), "a number of no channel"
        self.rows = y + height
        self.rounds += self.rows == self.height


class Viewer(threading.Thread):
    """Listens; `behaviour` is what it does with a connection. Its errors are the test's."""

    def __init__(self, behaviour=None, family=socket.AF_INET, port=0, buffer=None):
        super().__init__(daemon=True)
        self.listener = socket.socket(family, socket.SOCK_STREAM)
        self.listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        if buffer:
            self.listener.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, buffer)
        self.listener.bind(("::1" if family == socket.AF_INET6 else "127.0.0.1", port))
        self.listener.listen()
        self.listener.settimeout(60)
        self.port = self.listener.getsockname()[1]
        self.behaviour = behaviour or Viewer.read_all
        self.pictures, self.connections, self.error = {}, 0, None
        self.start()

    def run(self):
        try:
            while True:
                connection, _ = self.listener.accept()
                connection.settimeout(60)
                self.connections += 1
                with connection:
                    if self.behaviour(self, connection):
                        return
        except BaseException as error:  # noqa: B902: told by finish()
            self.error = error

    def finish(self):
        self.join(60)
        assert not self.is_alive(), "the viewer still waits"
        self.listener.close()
        if self.error:
            raise self.error

    @staticmethod
    def bytes_of(connection, count):
        data = bytearray()
        while len(data) < count:
            piece = connection.recv(min(count - len(data), 1 << 16))
            if not piece:
                assert not data, "the connection ends within a packet"
                return b""
            data += piece
        return bytes(data)

    def read_packet(self, connection):
        head = self.bytes_of(connection, 4)
        if not head:
            return False
        (size,) = struct.unpack("<I", head)
        assert 6 < size < 1 << 24, size
        packet = Reader(head + self.bytes_of(connection, size - 4))
        packet.at = 4
        operation, focus = packet.take("BB")
        assert (operation, focus) in ((CREATE, 1), (UPDATE, 0)), (operation, focus)
        if operation == CREATE:
            picture = Picture(packet)
            self.pictures[picture.name] = picture
        else:
            name = packet.data[packet.at:packet.data.index(b"\0", packet.at)].decode()
            self.pictures[name].update(packet)
        assert packet.at == size, "bytes behind the end of a packet"
        return True

    def read_all(self, connection):
        while self.read_packet(connection):
            pass
        return True


class Tev(unittest.TestCase):
    def setUp(self):
        self.begin = time.time()
        self.folder = tempfile.TemporaryDirectory()

    def tearDown(self):
        self.folder.cleanup()
        print("%.1f s" % (time.time() - self.begin), end=" ", file=sys.stderr, flush=True)

    def start(self, address, *more, scene=SCENE, size="40x30", spp="4"):
        return subprocess.Popen([ETENDUE, "render", scene, "--device", "reference", "--size", size, "--spp", spp, "-o", "p.exr",
                                 "--json", "--force", "--tev" + ("=" + address if address else ""), *more],
                                cwd=self.folder.name, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)

    def render(self, *arguments, **named):
        process = self.start(*arguments, **named)
        out, err = process.communicate(timeout=120)
        return process.returncode, json.loads(out) if out else None, err

    def expect_file(self, viewer, name="etendue: p.exr", others=()):
        """What the viewer shows in the end is the file, number for number."""
        width, height, values, _ = read_exr(os.path.join(self.folder.name, "p.exr"))
        picture = viewer.pictures[name]
        self.assertEqual((picture.width, picture.height, picture.rows), (width, height, height))
        self.assertEqual(sorted(picture.channels), sorted(values))
        self.assertEqual(picture.channels, COLORS + list(others))
        for channel in picture.channels:
            self.assertEqual(picture.values[channel], list(values[channel]), channel)

    def test_shows_what_the_file_holds(self):
        viewer = Viewer()
        code, report, err = self.render(f"127.0.0.1:{viewer.port}", "--aov", "albedo,depth,primitive", "--alpha")
        viewer.finish()
        self.assertEqual((code, "warning" in err), (0, False), err)
        self.expect_file(viewer, others=["A", "depth.Z", "primitive.X", "albedo.R", "albedo.G", "albedo.B"])
        self.assertTrue(report["tev"]["last"])
        self.assertEqual(report["tev"]["pictures"], viewer.pictures["etendue: p.exr"].rounds)
        self.assertEqual(report["tev"]["address"], f"127.0.0.1:{viewer.port}")

    def test_shows_it_while_it_renders_in_bands(self):
        viewer = Viewer()
        code, report, err = self.render(f"localhost:{viewer.port}", size="800x300", spp="2")
        viewer.finish()
        self.assertEqual(code, 0, err)
        self.assertGreater(report["tev"]["pictures"], 1)
        self.expect_file(viewer)

    def test_ipv6(self):
        try:
            viewer = Viewer(family=socket.AF_INET6)
        except OSError:
            return  # a machine without IPv6 has nothing to show here; addresses are tested below
        code, report, err = self.render(f"[::1]:{viewer.port}")
        viewer.finish()
        self.assertEqual(code, 0, err)
        self.assertEqual(report["tev"]["address"], f"[::1]:{viewer.port}")
        self.expect_file(viewer)

    def free_port(self):
        with socket.socket() as probe:
            probe.bind(("127.0.0.1", 0))
            return probe.getsockname()[1]

    def test_nobody_listens(self):
        code, report, err = self.render(f"127.0.0.1:{self.free_port()}")
        self.assertEqual((code, report["tev"]["pictures"], report["tev"]["last"]), (0, 0, False))
        self.assertEqual(err.count("warning:"), 1, err)
        self.assertIn("Connection refused", err)
        self.assertIn("the render continues", err)
        self.assertTrue(os.path.exists(os.path.join(self.folder.name, "p.exr")))

    def test_host_that_is_not_there(self):
        code, report, err = self.render("no-such-host.invalid:1234")
        self.assertEqual((code, report["tev"]["last"]), (0, False))
        self.assertEqual(err.count("warning:"), 1, err)
        self.assertIn("no-such-host.invalid:1234", err)

    def test_viewer_that_starts_later(self):
        port = self.free_port()
        process = self.start(f"127.0.0.1:{port}", size="200x150", spp="4000")
        time.sleep(1)
        viewer = Viewer(port=port)
        deadline = time.time() + 30
        while not viewer.pictures and time.time() < deadline:
            time.sleep(0.05)
        process.send_signal(signal.SIGINT)
        out, err = process.communicate(timeout=60)
        viewer.finish()
        self.assertEqual(process.returncode, 130, err)
        self.assertTrue(json.loads(out)["tev"]["last"])
        self.expect_file(viewer)

    def test_viewer_that_is_restarted(self):
        def once(viewer, connection):
            if viewer.connections == 1:
                viewer.read_packet(connection)
                return False  # closes with much unread
            return viewer.read_all(connection)

        viewer = Viewer(once)
        process = self.start(f"127.0.0.1:{viewer.port}", size="200x150", spp="4000")
        deadline = time.time() + 30
        while (viewer.connections < 2 or not viewer.pictures) and time.time() < deadline:
            time.sleep(0.05)
        process.send_signal(signal.SIGINT)
        out, err = process.communicate(timeout=60)
        viewer.finish()
        self.assertEqual(process.returncode, 130, err)
        self.assertEqual((err.count("warning:"), err.count("the render continues")), (1, 1), err)
        self.assertTrue(json.loads(out)["tev"]["last"])
        self.expect_file(viewer)

    def test_viewer_that_goes_away(self):
        def leave(viewer, connection):
            viewer.read_packet(connection)
            viewer.listener.close()
            return True

        viewer = Viewer(leave)
        code, report, err = self.render(f"127.0.0.1:{viewer.port}", spp="32")
        viewer.finish()
        self.assertEqual((code, report["tev"]["last"]), (0, False), err)
        self.assertEqual(err.count("warning:"), 1, err)

    def test_slow_viewer_gets_fewer_pictures_and_the_last(self):
        def slow(viewer, connection):
            time.sleep(3)  # the render goes on meanwhile
            return viewer.read_all(connection)

        viewer = Viewer(slow, buffer=1 << 14)
        code, report, err = self.render(f"127.0.0.1:{viewer.port}", size="400x300", spp="4")
        viewer.finish()
        self.assertEqual(code, 0, err)
        # One while it slept, then one each half second at most, and the last.
        self.assertLessEqual(report["tev"]["pictures"], 2 + max(report["seconds"] - 3, 0) / 0.5)
        self.assertTrue(report["tev"]["last"])
        self.expect_file(viewer)

    def test_deaf_viewer_is_given_up(self):
        release = threading.Event()

        def deaf(viewer, connection):
            release.wait(60)
            return True

        viewer = Viewer(deaf, buffer=1 << 14)
        start = time.time()
        code, report, err = self.render(f"127.0.0.1:{viewer.port}", size="500x400", spp="1")
        took = time.time() - start
        release.set()
        self.assertEqual((code, report["tev"]["last"]), (0, False), err)
        self.assertIn("less than 1 MiB in ten seconds", err)
        self.assertGreater(took, 9.0)
        viewer.finish()
        self.assertLess(took, 40.0)

    def test_names_are_clean(self):
        viewer = Viewer()
        process = subprocess.Popen([ETENDUE, "render", SCENE, "--device", "reference", "--size", "8x6", "--spp", "1", "-q", "-o",
                                    "a\x1b[31m\nb.exr", f"--tev=127.0.0.1:{viewer.port}"], cwd=self.folder.name)
        self.assertEqual(process.wait(60), 0)
        viewer.finish()
        self.assertEqual(list(viewer.pictures), ["etendue: a\ufffd[31m\ufffdb.exr"])

    def test_addresses(self):
        for address in ("host:0", "host:65536", "host:http", "host:", "[::1", "[::1]14158", "[::1]:", "[]:1", "host:-1", "host: 1",
                        "host:1x"):
            process = self.start(address)
            out, err = process.communicate(timeout=60)
            self.assertEqual((process.returncode, out), (2, ""), address)
            self.assertIn("--tev=", err)
            self.assertEqual(err.count("\n"), 1, err)


if __name__ == "__main__":
    unittest.main(verbosity=2)
