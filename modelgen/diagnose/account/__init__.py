"""What a diagnosis shows and tells: place, hold-out, pictures, words, the extended model."""
