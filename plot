# set-up saved by hooke 0.1.0
