"""The server: missions, agent processes, REST and the live stream."""

VERSION = "0.1.0"
