; Catch: a ball falls, move the cup under it. Three lives. A complete small game for the Atari 2600.
;
; Assemble with:  scripts/assemble.py examples/catch/catch.asm examples/catch/catch.bin
; The rules that tell an agent its reward, lives and the end of the game are in catch.toml.

; --- TIA and RIOT registers ---
VSYNC  = $00
VBLANK = $01
WSYNC  = $02
COLUP0 = $06
COLUPF = $08
COLUBK = $09
CTRLPF = $0A
RESP0  = $10
AUDC0  = $15
AUDF0  = $17
AUDV0  = $19
GRP0   = $1B
ENABL  = $1F
HMP0   = $20
HMOVE  = $2A
CXCLR  = $2C
CXP0FB = $02          ; read: bit 6 is player 0 meets ball
SWCHA  = $0280        ; joysticks: bit 7 right, bit 6 left, 0 when pressed
SWCHB  = $0282        ; bit 0: RESET, 0 when pressed
INTIM  = $0284
TIM64T = $0296

; --- the console's RAM ---
score  = $80          ; two decimal digits
lives  = $81
cup_x  = $82
ball_x = $83
ball_y = $84          ; lines above the bottom of the picture
random = $85
beep   = $86          ; frames the sound still lasts

CUP_LINE = 16         ; the cup's lowest line, counted from the bottom
TOP      = 186

        .org $F800

Start:  sei
        cld
        ldx #$FF
        txs
        lda #0
Clear:  sta $00,x     ; clears the TIA's registers and the RAM
        dex
        bne Clear
        lda #%00100000
        sta CTRLPF    ; the ball is four pixels wide
        lda #$1E
        sta COLUP0
        lda #$0E
        sta COLUPF
        lda #$82
        sta COLUBK
        lda #4
        sta AUDC0
        jsr NewGame

Frame:  lda #2        ; three lines of vertical synchronisation
        sta VSYNC
        sta WSYNC
        sta WSYNC
        sta WSYNC
        lda #0
        sta VSYNC

        lda #43       ; 37 lines of vertical blank, in which the objects are placed
        sta TIM64T
        lda cup_x
        ldx #0
        jsr Place
        lda ball_x
        ldx #4
        jsr Place
        sta WSYNC
        sta HMOVE
        sta CXCLR
        jsr Wait
        lda #0
        sta VBLANK

        ldx #192      ; the picture, from line 192 at the top to line 1
Line:   sta WSYNC
        ldy #8        ; which row of the cup: 8 is an empty one
        txa
        sec
        sbc #CUP_LINE
        cmp #8
        bcs NoCup
        tay
NoCup:  lda Cup,y
        sta GRP0
        txa
        sec
        sbc ball_y
        cmp #4
        lda #0
        bcs NoBall
        lda #2
NoBall: sta ENABL
        dex
        bne Line

        lda #2
        sta VBLANK
        lda #35       ; 30 lines of overscan, in which the game goes on
        sta TIM64T
        jsr Play
        jsr Wait
        jmp Frame

; Waits for the timer.
Wait:   lda INTIM
        bne Wait
        sta WSYNC
        rts

; Places object X (0 is player 0, 4 the ball) near column A.
Place:  sec
        sta WSYNC
Divide: sbc #15       ; five cycles, fifteen pixels
        bcs Divide
        eor #7
        asl
        asl
        asl
        asl
        sta RESP0,x
        sta HMP0,x
        rts

; One frame of the game.
Play:   lda SWCHB
        lsr
        bcs NotReset
        jmp NewGame
NotReset:
        lda beep
        beq Quiet
        dec beep
        bne Quiet
        lda #0
        sta AUDV0
Quiet:  lda lives
        beq Done      ; the game is over
        bit SWCHA
        bmi NotRight
        lda cup_x
        cmp #150
        bcs NotRight
        inc cup_x
        inc cup_x
NotRight:
        bit SWCHA
        bvs NotLeft
        lda cup_x
        cmp #4
        bcc NotLeft
        dec cup_x
        dec cup_x
NotLeft:
        bit CXP0FB
        bvs Caught
        dec ball_y
        dec ball_y
        lda ball_y
        cmp #6
        bcs Done
        dec lives     ; missed
        lda #24
        jmp NewBall
Caught: sed
        lda score
        clc
        adc #1
        sta score
        cld
        lda #6
NewBall:
        sta AUDF0     ; A is the pitch
        lda #8
        sta AUDV0
        sta beep
        lda #TOP
        sta ball_y
        lda random    ; a shift register with feedback: 255 places before it repeats
        lsr
        bcc NoTap
        eor #$B4
NoTap:  sta random
        and #$7F
        clc
        adc #16
        sta ball_x
Done:   rts

NewGame:
        lda #0
        sta score
        lda #3
        sta lives
        lda #80
        sta cup_x
        lda #1
        sta random
        lda #24
        jmp NewBall

Cup:    .byte %00111100, %01111110, %11111111, %11000011, %11000011, %11000011, %11000011, %11000011, 0

        .org $FFFC
        .word Start, Start
