"""Commands about what is kept: settings, my data, being forgotten, archives of chats."""
