"""From the files of a motion-capture lab to a recording bundle."""
