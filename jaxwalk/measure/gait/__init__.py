"""A gait laboratory: what a walker's joints and soles do over a stride, beside what people do.

forces -> record -> strides, signals -> energy, measures -> human, report -> picture -> command
"""
