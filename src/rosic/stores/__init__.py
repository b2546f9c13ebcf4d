"""Where the record is kept: in a database on disk, or in memory."""
