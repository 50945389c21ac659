"""Small components that keep their contracts, and wrong ones that break them."""
