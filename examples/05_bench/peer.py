"""A machine of one axis in Python: the position follows command / 12 with a lag of 5 ms.

    python3 peer.py [PORT [SECONDS]]

It speaks the packet of docs/gateway.md, listens to one peer, and stops itself without commands.
"""
import socket
import struct
import sys
import time
import zlib

HEADER = struct.Struct("<4sBBHIIQIBBHQ")  # 40 bytes
ENABLE, POWERED, VALID, SAFE = 1, 1 << 8, 1 << 9, 1 << 10
PORT = int(sys.argv[1]) if len(sys.argv) > 1 else 9000
SECONDS = float(sys.argv[2]) if len(sys.argv) > 2 else float("inf")
HEARTBEAT = 0.1  # s without a command until the machine stops itself


def decode(packet, channels):
    """Header and values of a command, or None for anything else."""
    if len(packet) != HEADER.size + 8 * channels + 4:
        return None
    body, checksum = packet[:-4], struct.unpack("<I", packet[-4:])[0]
    header = HEADER.unpack_from(body)
    if zlib.crc32(body) != checksum or header[:4] != (b"PZLB", 1, 1, channels):
        return None
    return header, struct.unpack_from(f"<{channels}d", body, HEADER.size)


def encode(sequence, status, echo_sequence, echo_time, values):
    header = (b"PZLB", 1, 2, len(values), sequence, status, time.monotonic_ns())
    body = HEADER.pack(*header, echo_sequence, 0, 0, 0, echo_time)
    body += struct.pack(f"<{len(values)}d", *values)
    return body + struct.pack("<I", zlib.crc32(body))


link = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
link.bind(("127.0.0.1", PORT))
link.connect(("127.0.0.1", PORT + 1))  # from now on nobody else is heard
link.settimeout(0.01)
print(f"listening at udp://127.0.0.1:{PORT}", flush=True)

position, applied, stopped, newest = 0.0, 0.0, False, None
sequence, last_command, last_step = 0, time.monotonic(), time.monotonic()
begin = time.monotonic()
while time.monotonic() - begin < SECONDS:
    try:
        command = decode(link.recv(2048), 1)
    except (socket.timeout, ConnectionRefusedError):
        command = None
    now = time.monotonic()
    if command:
        header, values = command
        if newest is None or 0 < (header[4] - newest[4]) % 2**32 < 2**31:
            newest, last_command = header, now
            enabled = bool(header[5] & ENABLE)
            stopped = stopped and enabled
            applied = values[0] if enabled and not stopped else 0.0
    if newest and newest[5] & ENABLE and now - last_command > HEARTBEAT:
        stopped, applied = True, 0.0
    position += (applied / 12 - position) * min(1.0, (now - last_step) / 5e-3)
    last_step = now
    if newest:
        sequence += 1
        status = POWERED | VALID | (SAFE if stopped else 0)
        try:
            link.send(encode(sequence, status, newest[4], newest[6], [position]))
        except ConnectionRefusedError:
            pass
