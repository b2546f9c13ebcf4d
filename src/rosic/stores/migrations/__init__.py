"""How the tables came to be, step by step, from the first one on. Alembic runs them at opening."""
