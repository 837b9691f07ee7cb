"""Virtual scans: a model of a depth-camera scanner, of mannequins and of garments. Nothing here was measured."""
