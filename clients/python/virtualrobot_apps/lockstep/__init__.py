"""`virtualrobot lockstep`: time that waits for an outside controller, in any language, by lines of JSON."""
