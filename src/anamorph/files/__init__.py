"""Models, CAD files, images and scene files: in and out."""
