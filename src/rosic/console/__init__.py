"""The page: files that a browser is given, and what is said in them. A client of the API."""
