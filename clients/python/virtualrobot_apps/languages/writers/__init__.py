"""Programs of the kernel written in the languages of robots' controllers."""
