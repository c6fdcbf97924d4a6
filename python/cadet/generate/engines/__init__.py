"""What makes a dataset's episodes: processes of this machine, or a Ray cluster."""
