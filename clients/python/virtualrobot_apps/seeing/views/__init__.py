"""Next best views: where a range sensor looks next, so that a body is seen from all sides in few scans."""
