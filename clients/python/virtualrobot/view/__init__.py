"""The view: its set-up, pictures, films and what is measured in it."""
