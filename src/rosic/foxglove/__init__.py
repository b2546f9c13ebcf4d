"""What Foxglove reads: messages in its schemas, and MCAP files. Values in, bytes out; no I/O."""
