"""rosbridge protocol v2 over a WebSocket, with the rights, limits and record of everything else."""
