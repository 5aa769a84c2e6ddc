# Turn controller: from a heading setpoint to a turn output, with a model of the chair.
