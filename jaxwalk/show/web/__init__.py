"""What pages that draw a walker share: the document around them, the figure, and how it is drawn."""
